#include "datasets/number_table.h"

#include <charconv>
#include <cstring>

#include "common/error.h"

namespace hymm::core {
namespace {

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Walks over a text once and remembers where it is only as far as a sentence needs it.
class TableParser {
 public:
  TableParser(std::string_view text, std::size_t columns, RowEnd row_end, const std::string& origin)
      : at_(text.data()),
        end_(text.data() + text.size()),
        line_start_(at_),
        row_end_(row_end),
        origin_(origin) {
    table_.columns = columns;
  }

  NumberTable parse() {
    while (at_ != end_) {
      if (isBlank(*at_)) {
        ++at_;
      } else if (*at_ == '\n') {
        endLine();
      } else if (numbers_in_line_ == 0 && (*at_ == '#' || *at_ == '%')) {
        const void* newline = std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_));
        at_ = newline != nullptr ? static_cast<const char*>(newline) : end_;
      } else {
        readNumber();
      }
    }
    endLine();
    if (table_.values.size() % table_.columns != 0) failIncomplete();
    return std::move(table_);
  }

 private:
  void readNumber() {
    double value = 0.0;
    const char* start = *at_ == '+' ? at_ + 1 : at_;
    const auto [next, error] = std::from_chars(start, end_, value);
    if (error != std::errc{} || (next != end_ && !isBlank(*next) && *next != '\n')) {
      failNumber();
    }
    table_.values.push_back(value);
    ++numbers_in_line_;
    at_ = next;
  }

  void endLine() {
    if (row_end_ == RowEnd::kLine && numbers_in_line_ != 0 && numbers_in_line_ != table_.columns) {
      throw InputError(origin_ + ", line " + std::to_string(line_) + ": has " +
                       std::to_string(numbers_in_line_) + " numbers instead of " +
                       std::to_string(table_.columns) +
                       "; the file is cut off or damaged, get it again.");
    }
    if (at_ == end_) return;
    ++at_;
    ++line_;
    line_start_ = at_;
    numbers_in_line_ = 0;
  }

  [[noreturn]] void failNumber() const {
    const char* word_end = at_;
    while (word_end != end_ && !isBlank(*word_end) && *word_end != '\n' && word_end - at_ < 20) {
      ++word_end;
    }
    throw InputError(origin_ + ", line " + std::to_string(line_) + ", character " +
                     std::to_string(at_ - line_start_ + 1) + ": '" + std::string(at_, word_end) +
                     "' is not a number (row " + std::to_string(table_.rows() + 1) + ", column " +
                     std::to_string(table_.values.size() % table_.columns + 1) +
                     "); correct it or get the file again.");
  }

  [[noreturn]] void failIncomplete() const {
    throw InputError(origin_ + ": ends within row " + std::to_string(table_.rows() + 1) +
                     ", after column " + std::to_string(table_.values.size() % table_.columns) +
                     " of " + std::to_string(table_.columns) +
                     "; the file is cut off or damaged, get it again.");
  }

  const char* at_;
  const char* end_;
  const char* line_start_;
  RowEnd row_end_;
  const std::string& origin_;
  std::size_t line_ = 1;
  std::size_t numbers_in_line_ = 0;
  NumberTable table_;
};

}  // namespace

NumberTable parseNumberTable(std::string_view text, std::size_t columns, RowEnd row_end,
                             const std::string& origin) {
  return TableParser(text, columns, row_end, origin).parse();
}

std::optional<double> tryParseNumber(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [next, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || next != word.data() + word.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> splitWords(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (at < line.size()) {
    while (at < line.size() && isBlank(line[at])) ++at;
    const std::size_t start = at;
    while (at < line.size() && !isBlank(line[at])) ++at;
    if (at > start) words.push_back(line.substr(start, at - start));
  }
  return words;
}

}  // namespace hymm::core
