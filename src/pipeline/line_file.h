#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace hymm::core {

/// A text file that grows by whole lines. They wait in memory until they are flushed, so that files
/// that belong together can reach the disk together, and one that is cut off ends with a line. What
/// could not be written waits on: a disk that was full for a while costs no line.
class LineFile {
 public:
  /// Touches nothing: the first flush makes the file, in place of one that is there.
  explicit LineFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// `line` without its end.
  void add(const std::string& line);

  /// Bytes that wait.
  std::size_t waiting() const { return lines_.size(); }

  /// Writes what waits. Throws OutputError if it could not be written whole; the file then is as it
  /// was, and all of it waits for the next flush.
  void flush() { flushTogether({this}); }

  /// The same of several files: each has all of its lines afterwards, or none of them has a new
  /// one.
  static void flushTogether(const std::vector<LineFile*>& files);

 private:
  void write() const;
  void keep();
  void takeBack() const;

  std::filesystem::path path_;
  std::string lines_;
  bool is_made_ = false;
  std::uintmax_t size_ = 0;  ///< of what is written and kept
};

}  // namespace hymm::core
