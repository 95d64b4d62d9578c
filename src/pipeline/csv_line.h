#pragma once

#include <cstddef>
#include <string>

#include "common/number_text.h"

namespace hymm::core {

inline std::string csvField(double value) { return numberText(value); }
inline std::string csvField(int value) { return std::to_string(value); }
inline std::string csvField(std::size_t value) { return std::to_string(value); }

/// A text as a CSV field: quoted where a comma, a quote or a line break would break the line.
std::string csvField(const std::string& text);

/// The fields of a line, without its end.
template <class First, class... Rest>
std::string csvLine(char separator, const First& first, const Rest&... rest) {
  std::string line = csvField(first);
  ((line += separator, line += csvField(rest)), ...);
  return line;
}

}  // namespace hymm::core
