#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hymm::core {

/// Numbers in rows of equal length, row after row.
struct NumberTable {
  std::size_t columns = 0;
  std::vector<double> values;

  std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// What ends a row: the end of its line, or just its last number. LASER.txt of Victoria Park is a
/// single line of all scans.
enum class RowEnd { kLine, kLastNumber };

/// Parses numbers separated by blanks or tabs; lines that begin with # or % are comments. Throws
/// InputError, which leads with `origin` and names line and character, for what is not a number
/// and for a row of another length.
NumberTable parseNumberTable(std::string_view text, std::size_t columns, RowEnd row_end,
                             const std::string& origin);

/// The number that `word` spells, all of it; nothing if it spells none.
std::optional<double> tryParseNumber(std::string_view word);

/// The words of a line, separated by blanks or tabs.
std::vector<std::string_view> splitWords(std::string_view line);

}  // namespace hymm::core
