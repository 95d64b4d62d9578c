#include "common/unfinished_file.h"

#include <fstream>
#include <system_error>

#include "common/error.h"

namespace hymm::core {

namespace fs = std::filesystem;

UnfinishedFile::UnfinishedFile(fs::path target) : target_(std::move(target)), path_(target_) {
  path_ += ".active";
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (target_.filename().empty() || fs::is_directory(target_)) {
    throw OutputError("The output " + target_.string() + " is a folder; name a file in it.");
  }
  if (!fs::is_directory(folder)) {
    throw OutputError(target_.string() + " cannot be written: the folder " + folder.string() +
                      " does not exist; make it.");
  }
}

UnfinishedFile::~UnfinishedFile() {
  std::error_code ignored;
  if (!is_complete_) fs::remove(path_, ignored);
}

void UnfinishedFile::complete() {
  std::error_code error;
  fs::rename(path_, target_, error);
  if (error) {
    throw OutputError(path_.string() + " cannot be renamed to " + target_.filename().string() +
                      " (" + error.message() + "); check the folder's permissions.");
  }
  is_complete_ = true;
}

void replaceFile(const fs::path& path, const std::string& content) {
  UnfinishedFile unfinished(path);
  std::ofstream file(unfinished.path(), std::ios::binary | std::ios::trunc);
  file << content;
  file.close();
  if (!file) {
    throw OutputError(unfinished.path().string() + ": could not be written; is the disk full?");
  }
  unfinished.complete();
}

}  // namespace hymm::core
