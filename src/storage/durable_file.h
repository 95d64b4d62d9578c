#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace hymm::core {

/// Told before each step that changes the disk, so that tests can end the process there: what it
/// throws, the step is not done.
class DiskWatch {
 public:
  virtual ~DiskWatch() = default;
  virtual void before(const std::string& step) = 0;
};

/// A file that is written beside its place, as NAME.active, reaches the disk, and is then given its
/// name: a kill or a power failure at any moment leaves what was there before, or all of the new.
/// What a kill leaves beside it does no harm.
class DurableFile {
 public:
  /// `watch` may be null. Throws OutputError.
  DurableFile(std::filesystem::path folder, DiskWatch* watch);
  /// Removes what was not given its name.
  ~DurableFile();
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  /// Begins the file `name`.active in the folder.
  void open(const std::string& name);
  void write(const void* data, std::size_t size);
  /// Brings everything to the disk, and replaces `name` by it.
  void complete(const std::string& name);

 private:
  void step(const std::string& what) const {
    if (watch_ != nullptr) watch_->before(what);
  }
  [[noreturn]] void fail(const std::string& what) const;
  void syncFolder() const;

  std::filesystem::path folder_;
  DiskWatch* watch_;
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Removes a file; one that is not there does no harm.
void removeDurably(const std::filesystem::path& file, DiskWatch* watch);

}  // namespace hymm::core
