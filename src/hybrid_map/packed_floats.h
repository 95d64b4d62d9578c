#pragma once

#include <cstddef>
#include <vector>

#include "hybrid_map/packed_bytes.h"

namespace hymm::core {

/// Numbers compressed without loss.
class PackedFloats {
 public:
  PackedFloats() = default;
  explicit PackedFloats(const std::vector<float>& values);

  bool isEmpty() const { return bytes_.isEmpty(); }
  std::vector<float> unpack() const;

  std::size_t bytes() const { return bytes_.bytes(); }
  std::size_t unpackedBytes() const { return bytes_.unpackedBytes(); }

 private:
  PackedBytes bytes_;
};

}  // namespace hymm::core
