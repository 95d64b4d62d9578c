#pragma once

#include <array>
#include <cstddef>

namespace hymm::core {

/// Quantiles of times between 1 microsecond and 1000 seconds in constant memory: counts in bins
/// each half a percent wider than the one before. Quantiles are right to that half percent; the
/// maximum is exact.
class LatencyHistogram {
 public:
  /// A time in milliseconds; one that is not finite is not counted.
  void add(double time_ms);

  /// Time [ms] that the share `probability` of all times does not exceed; 0 without any.
  double quantile(double probability) const;
  double max() const { return max_ms_; }
  std::size_t count() const { return count_; }

 private:
  static constexpr std::size_t kBins = 4200;
  std::array<std::size_t, kBins> bins_{};
  std::size_t count_ = 0;
  double max_ms_ = 0.0;
};

}  // namespace hymm::core
