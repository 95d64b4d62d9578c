#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace hymm::core {

/// The files of a recording, in a .zip archive or in a folder. Files are asked for by name, upper
/// and lower case alike, in whatever folder of the archive they lie. Sentences of InputError name
/// the archive or folder, the file, and what to do.
class FileSource {
 public:
  /// Lists what is there. Throws InputError if it is neither a readable archive nor a folder.
  explicit FileSource(const std::filesystem::path& path);

  bool contains(const std::string& name) const;

  /// The whole file. Throws InputError if it is missing, there twice, or damaged.
  std::string read(const std::string& name) const;

  /// How sentences name one of the files.
  std::string origin(const std::string& name) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  void listFolder();
  void listArchive();
  std::string readFromArchive(const std::string& member, const std::string& origin) const;

  std::filesystem::path path_;
  bool is_archive_ = false;
  std::multimap<std::string, std::string> members_;  ///< lower-case name to path in the source
};

/// The whole of a file. Throws InputError.
std::string readFile(const std::filesystem::path& path);

}  // namespace hymm::core
