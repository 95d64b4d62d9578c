#pragma once

#include <filesystem>
#include <string>

namespace hymm::core {

/// A file in the making: written as NAME.active beside its place and renamed when complete, so that
/// a failure leaves neither half a file nor a damaged older one.
class UnfinishedFile {
 public:
  /// Throws OutputError if the target cannot be a file: its folder is missing, or it is a folder.
  explicit UnfinishedFile(std::filesystem::path target);

  /// Removes what was written, unless it was completed.
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// Where to write.
  const std::filesystem::path& path() const { return path_; }

  /// Gives the closed file its name. Throws OutputError if that fails.
  void complete();

 private:
  std::filesystem::path target_;
  std::filesystem::path path_;
  bool is_complete_ = false;
};

/// Writes a whole file at once: whoever reads it finds the content before or this one, never a part
/// of it. Throws OutputError.
void replaceFile(const std::filesystem::path& path, const std::string& content);

}  // namespace hymm::core
