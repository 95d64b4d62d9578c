#include "hybrid_map/packed_floats.h"

#include <cstdint>
#include <cstring>

namespace hymm::core {
namespace {

/// The first bytes of all numbers, then all second ones, and so on: signs and exponents, which
/// repeat, come to lie side by side.
std::vector<std::uint8_t> bytesApart(const std::vector<float>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint8_t number[sizeof(float)];
    std::memcpy(number, &values[i], sizeof(float));
    for (std::size_t b = 0; b < sizeof(float); ++b) bytes[b * values.size() + i] = number[b];
  }
  return bytes;
}

}  // namespace

PackedFloats::PackedFloats(const std::vector<float>& values) : bytes_(bytesApart(values)) {}

std::vector<float> PackedFloats::unpack() const {
  const std::vector<std::uint8_t> bytes = bytes_.unpack();
  std::vector<float> values(bytes.size() / sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint8_t number[sizeof(float)];
    for (std::size_t b = 0; b < sizeof(float); ++b) number[b] = bytes[b * values.size() + i];
    std::memcpy(&values[i], number, sizeof(float));
  }
  return values;
}

}  // namespace hymm::core
