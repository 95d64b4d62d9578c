#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hymm::core {

/// Bytes compressed without loss (zstd).
class PackedBytes {
 public:
  PackedBytes() = default;
  explicit PackedBytes(const std::vector<std::uint8_t>& bytes);

  bool isEmpty() const { return count_ == 0; }
  std::vector<std::uint8_t> unpack() const;

  std::size_t bytes() const { return content_.capacity(); }
  std::size_t unpackedBytes() const { return count_; }

 private:
  std::vector<std::uint8_t> content_;
  std::size_t count_ = 0;
};

}  // namespace hymm::core
