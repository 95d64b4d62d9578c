#include "hybrid_map/packed_bytes.h"

#include <stdexcept>

#include <zstd.h>

namespace hymm::core {
namespace {

// Higher levels hardly gain on grids, but cost many times the time.
constexpr int kLevel = 3;

}  // namespace

PackedBytes::PackedBytes(const std::vector<std::uint8_t>& bytes) : count_(bytes.size()) {
  if (bytes.empty()) return;
  std::vector<std::uint8_t> buffer(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compress(buffer.data(), buffer.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::runtime_error("zstd cannot compress a layer");
  content_.assign(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size));
}

std::vector<std::uint8_t> PackedBytes::unpack() const {
  std::vector<std::uint8_t> bytes(count_);
  if (bytes.empty()) return bytes;
  const std::size_t size =
      ZSTD_decompress(bytes.data(), bytes.size(), content_.data(), content_.size());
  if (size != bytes.size()) throw std::runtime_error("zstd cannot restore a layer");
  return bytes;
}

}  // namespace hymm::core
