#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hymm::core {

/// A CSV file with a header, read whole. Fields may be quoted as RFC 4180 has it, but hold no line
/// breaks. Sentences of InputError name the file, the line and the column.
class CsvTable {
 public:
  /// Throws InputError if the file cannot be read, is empty, or has a line of another length.
  explicit CsvTable(const std::string& file);

  std::size_t rows() const { return rows_.size(); }
  bool has(const std::string& column) const;

  /// Values of a column, "nan" and "inf" among them. Throws InputError if there is no such column,
  /// or for a field that is no number.
  std::vector<double> numbers(const std::string& column) const;

  /// Throws InputError if there is no such column.
  std::vector<std::string> texts(const std::string& column) const;

 private:
  std::size_t find(const std::string& column) const;

  std::string file_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

/// Rows of numbers without a header, separated by blanks, tabs or commas; empty lines and comments
/// (# or %) are skipped. Throws InputError for anything else and for rows of fewer numbers than
/// `columns`; further numbers in a row are ignored.
std::vector<std::vector<double>> readNumberRows(const std::string& file, std::size_t columns);

/// Whether the first line of a file is a CSV header: it holds letters. Throws InputError if the
/// file cannot be read.
bool hasHeader(const std::string& file);

}  // namespace hymm::core
