#include "hybrid_map/packed_floats.h"

#include <cstring>
#include <stdexcept>

#include <zstd.h>

namespace hymm::core {
namespace {

// Higher levels hardly gain on grids, but cost many times the time.
constexpr int kLevel = 3;

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

PackedFloats::PackedFloats(const std::vector<float>& values) : count_(values.size()) {
  const std::vector<std::uint8_t> bytes = bytesApart(values);
  std::vector<std::uint8_t> buffer(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compress(buffer.data(), buffer.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::runtime_error("zstd cannot compress a layer");
  content_.assign(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size));
}

std::vector<float> PackedFloats::unpack() const {
  std::vector<std::uint8_t> bytes(unpackedBytes());
  const std::size_t size =
      ZSTD_decompress(bytes.data(), bytes.size(), content_.data(), content_.size());
  if (size != bytes.size()) throw std::runtime_error("zstd cannot restore a layer");
  std::vector<float> values(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    std::uint8_t number[sizeof(float)];
    for (std::size_t b = 0; b < sizeof(float); ++b) number[b] = bytes[b * count_ + i];
    std::memcpy(&values[i], number, sizeof(float));
  }
  return values;
}

}  // namespace hymm::core
