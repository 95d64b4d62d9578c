#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

namespace hymm::core {

/// A text file that grows by whole lines. They wait in memory until flush(), so that files that
/// belong together can reach the disk together, and one that is cut off ends with a line.
class LineFile {
 public:
  /// Makes the file, empty. Throws OutputError.
  explicit LineFile(const std::filesystem::path& path);

  /// `line` without its end.
  void add(const std::string& line);

  /// Bytes that wait.
  std::size_t waiting() const { return lines_.size(); }

  /// Writes what waits. Throws OutputError if it, or anything before it, could not be written.
  void flush();

 private:
  std::filesystem::path path_;
  std::ofstream file_;
  std::string lines_;
};

}  // namespace hymm::core
