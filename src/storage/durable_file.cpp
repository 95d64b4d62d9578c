#include "storage/durable_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "common/error.h"

namespace hymm::core {

namespace fs = std::filesystem;

DurableFile::DurableFile(fs::path folder, DiskWatch* watch)
    : folder_(std::move(folder)), watch_(watch) {}

DurableFile::~DurableFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (path_.empty()) return;
  try {
    removeDurably(path_, watch_);
  } catch (...) {  // it stays, and does no harm
  }
}

void DurableFile::fail(const std::string& what) const {
  const std::string reason = std::strerror(errno);
  throw OutputError(path_.string() + " cannot be " + what + " (" + reason +
                    "); check the folder's permissions and the space on the disk.");
}

void DurableFile::open(const std::string& name) {
  step("open " + name);
  path_ = folder_ / (name + ".active");
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail("made");
}

void DurableFile::write(const void* data, std::size_t size) {
  const auto* next = static_cast<const char*>(data);
  while (size > 0) {
    step("write");
    const ssize_t written = ::write(descriptor_, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("written");
    next += written;
    size -= static_cast<std::size_t>(written);
  }
}

void DurableFile::complete(const std::string& name) {
  step("sync");
  if (::fsync(descriptor_) != 0) fail("brought to the disk");
  step("close");
  const int descriptor = std::exchange(descriptor_, -1);
  if (::close(descriptor) != 0) fail("written");
  step("rename " + name);
  if (::rename(path_.c_str(), (folder_ / name).c_str()) != 0) fail("renamed to " + name);
  path_.clear();
  syncFolder();
}

/// Else a power failure could undo the renaming.
void DurableFile::syncFolder() const {
  step("sync folder");
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

void removeDurably(const fs::path& file, DiskWatch* watch) {
  if (watch != nullptr) watch->before("remove " + file.filename().string());
  std::error_code ignored;
  fs::remove(file, ignored);
}

}  // namespace hymm::core
