#pragma once

#include <csignal>
#include <stdexcept>

#include <sys/resource.h>

namespace hymm::test {

/// As long as it lives, no file of this process grows beyond so many bytes: writing stops there as
/// it does on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : on_limit_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &limit_);
    rlimit full = limit_;
    full.rlim_cur = bytes;
    if (setrlimit(RLIMIT_FSIZE, &full) != 0) throw std::runtime_error("no limit of files");
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, on_limit_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*on_limit_)(int);
  rlimit limit_{};
};

}  // namespace hymm::test
