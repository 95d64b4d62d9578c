#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "hybrid_map/packed_bytes.h"

namespace hymm::core {

/// A bit for each cell of a region; takes no memory until one is set. Bits that are packed are
/// unpacked before they are asked for or changed.
class CellMarks {
 public:
  static constexpr double kBytesPerCell = 1.0 / 8.0;

  bool has(int cell) const {
    const auto at = std::size_t(cell);
    return at / 8 < bits_.size() && (bits_[at / 8] >> (at % 8) & 1U) != 0U;
  }
  /// `cells`: of the region.
  void set(int cell, int cells) {
    const auto at = std::size_t(cell);
    bits_.resize(bytesFor(cells));
    bits_[at / 8] = static_cast<std::uint8_t>(bits_[at / 8] | 1U << (at % 8));
  }
  void reset(int cell) {
    const auto at = std::size_t(cell);
    if (has(cell)) bits_[at / 8] = static_cast<std::uint8_t>(bits_[at / 8] & ~(1U << (at % 8)));
  }

  void pack() {
    packed_ = PackedBytes(bits_);
    bits_ = std::vector<std::uint8_t>();
  }
  void unpack() {
    bits_ = packed_.unpack();
    packed_ = PackedBytes();
  }
  std::size_t unpackedBytes() const { return bits_.capacity(); }
  std::size_t packedBytes() const { return packed_.bytes(); }
  std::size_t packedFromBytes() const { return packed_.unpackedBytes(); }

  /// Eight cells to a byte, packed or not.
  std::vector<std::uint8_t> bits() const { return packed_.isEmpty() ? bits_ : packed_.unpack(); }
  /// Whether these can be the bits of a region of so many cells.
  static bool fit(const std::vector<std::uint8_t>& bits, int cells) {
    return bits.empty() || bits.size() == bytesFor(cells);
  }
  void setBits(std::vector<std::uint8_t> bits) {
    bits_ = std::move(bits);
    packed_ = PackedBytes();
  }

 private:
  static std::size_t bytesFor(int cells) { return (std::size_t(cells) + 7) / 8; }

  std::vector<std::uint8_t> bits_;
  PackedBytes packed_;
};

}  // namespace hymm::core
