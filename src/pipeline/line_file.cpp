#include "pipeline/line_file.h"

#include "common/error.h"

namespace hymm::core {

LineFile::LineFile(const std::filesystem::path& path)
    : path_(path), file_(path, std::ios::binary | std::ios::trunc) {
  if (!file_) throw OutputError(path_.string() + ": cannot be opened for writing.");
}

void LineFile::add(const std::string& line) {
  lines_ += line;
  lines_ += '\n';
}

void LineFile::flush() {
  // The stream's own buffer is empty here, so that one call hands over all lines.
  file_.write(lines_.data(), static_cast<std::streamsize>(lines_.size()));
  file_.flush();
  lines_.clear();
  if (!file_) {
    throw OutputError(path_.string() + ": could not be written whole; is the disk full?");
  }
}

}  // namespace hymm::core
