#include "pipeline/line_file.h"

#include <fstream>
#include <system_error>

#include "common/error.h"

namespace hymm::core {

void LineFile::add(const std::string& line) {
  lines_ += line;
  lines_ += '\n';
}

void LineFile::flushTogether(const std::vector<LineFile*>& files) {
  std::vector<const LineFile*> begun;
  try {
    for (const LineFile* file : files) {
      begun.push_back(file);
      file->write();
    }
  } catch (const OutputError&) {
    for (const LineFile* file : begun) file->takeBack();
    throw;
  }
  for (LineFile* file : files) file->keep();
}

/// Through a stream of its own, which has no failure of an earlier one, nor what that one held.
void LineFile::write() const {
  if (is_made_ && lines_.empty()) return;
  // One that was made and is gone is not made again: its beginning would be missing.
  const auto mode = is_made_ ? std::ios::in : std::ios::trunc;
  std::ofstream file(path_, std::ios::binary | std::ios::out | mode);
  if (!file) throw OutputError(path_.string() + ": cannot be opened for writing.");
  file.seekp(static_cast<std::streamoff>(size_));
  // The stream's own buffer is empty here, so that one call hands over all lines.
  file.write(lines_.data(), static_cast<std::streamsize>(lines_.size()));
  file.close();
  if (!file) throw OutputError(path_.string() + ": could not be written whole; is the disk full?");
}

void LineFile::keep() {
  is_made_ = true;
  size_ += lines_.size();
  lines_.clear();
}

void LineFile::takeBack() const {
  // Where this fails, the next write covers what is too much.
  std::error_code ignored;
  std::filesystem::resize_file(path_, size_, ignored);
}

}  // namespace hymm::core
