#include "evaluation/csv_table.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "common/error.h"

namespace hymm::core {
namespace {

std::ifstream open(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file + ": cannot be opened; is the path right?");
  return stream;
}

bool readLine(std::istream& stream, std::string& line) {
  if (!std::getline(stream, line)) return false;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return true;
}

std::vector<std::string> splitFields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (is_quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[++i];
      else
        is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  return fields;
}

/// strtod in the C locale, which these tools never leave; all of `text` has to be a number.
std::optional<double> tryParse(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0') return std::nullopt;
  return value;
}

[[noreturn]] void fail(const std::string& file, std::size_t line, const std::string& problem) {
  throw InputError(file + ", line " + std::to_string(line) + ": " + problem + ".");
}

}  // namespace

CsvTable::CsvTable(const std::string& file) : file_(file) {
  std::ifstream stream = open(file);
  std::string line;
  if (!readLine(stream, line) || line.empty()) throw InputError(file + ": has no header.");
  header_ = splitFields(line);
  for (std::size_t number = 2; readLine(stream, line); ++number) {
    if (line.empty()) continue;
    rows_.push_back(splitFields(line));
    if (rows_.back().size() != header_.size()) {
      fail(file, number,
           "has " + std::to_string(rows_.back().size()) + " fields, but the header " +
               std::to_string(header_.size()));
    }
  }
}

bool CsvTable::has(const std::string& column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

std::size_t CsvTable::find(const std::string& column) const {
  const auto place = std::find(header_.begin(), header_.end(), column);
  if (place == header_.end()) throw InputError(file_ + ": has no column '" + column + "'.");
  return static_cast<std::size_t>(place - header_.begin());
}

std::vector<std::string> CsvTable::texts(const std::string& column) const {
  const std::size_t index = find(column);
  std::vector<std::string> texts;
  texts.reserve(rows_.size());
  for (const auto& row : rows_) texts.push_back(row[index]);
  return texts;
}

std::vector<double> CsvTable::numbers(const std::string& column) const {
  std::vector<double> numbers;
  numbers.reserve(rows_.size());
  for (const std::string& text : texts(column)) {
    const std::optional<double> number = tryParse(text);
    if (!number) {
      fail(file_, numbers.size() + 2, "column '" + column + "' holds '" + text + "', not a number");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<std::vector<double>> readNumberRows(const std::string& file, std::size_t columns) {
  std::ifstream stream = open(file);
  std::vector<std::vector<double>> rows;
  std::string line;
  for (std::size_t number = 1; readLine(stream, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos || line[first] == '#' || line[first] == '%') continue;
    std::vector<double> row;
    const char* place = line.c_str();
    for (char* end = nullptr; row.size() < columns; place = end) {
      row.push_back(std::strtod(place, &end));
      if (end == place) {
        fail(file, number, "does not begin with " + std::to_string(columns) + " numbers");
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

bool hasHeader(const std::string& file) {
  std::ifstream stream = open(file);
  std::string line;
  readLine(stream, line);
  const std::size_t first = line.find_first_not_of(" \t");
  // Numbers hold letters too ("1e5", "nan"), but none begins with one that a name begins with here.
  return first != std::string::npos && std::isalpha(static_cast<unsigned char>(line[first])) != 0;
}

}  // namespace hymm::core
