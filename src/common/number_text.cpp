#include "common/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace hymm::core {

std::string numberText(double value) {
  if (std::isnan(value)) return "nan";  // to_chars would tell the sign of a NaN
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return std::string(buffer.data(), end);
}

}  // namespace hymm::core
