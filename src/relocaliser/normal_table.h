#pragma once

#include <array>
#include <cstddef>

namespace hymm::core {

/// Quantiles of the standard normal distribution in even steps of probability, scaled to a variance
/// of exactly one: an even random index gives a normal sample (up to 4 deviations) for one lookup.
class NormalTable {
 public:
  static constexpr std::size_t kSize = 16384;  // 64 kB; a power of two

  static const NormalTable& instance();
  const float* data() const { return values_.data(); }

 private:
  NormalTable();

  std::array<float, kSize> values_;
};

}  // namespace hymm::core
