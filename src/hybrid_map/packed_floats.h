#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hymm::core {

/// Numbers compressed without loss (zstd).
class PackedFloats {
 public:
  PackedFloats() = default;
  explicit PackedFloats(const std::vector<float>& values);

  bool isEmpty() const { return count_ == 0; }
  std::vector<float> unpack() const;

  std::size_t bytes() const { return content_.capacity(); }
  std::size_t unpackedBytes() const { return count_ * sizeof(float); }

 private:
  std::vector<std::uint8_t> content_;
  std::size_t count_ = 0;
};

}  // namespace hymm::core
