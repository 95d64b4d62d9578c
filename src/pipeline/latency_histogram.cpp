#include "pipeline/latency_histogram.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

constexpr double kSmallest_ms = 1e-3;
const double kLogGrowth = std::log(1.005);

}  // namespace

void LatencyHistogram::add(double time_ms) {
  if (!std::isfinite(time_ms)) return;
  const double bin =
      std::ceil(std::log(std::max(time_ms, kSmallest_ms) / kSmallest_ms) / kLogGrowth);
  ++bins_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++count_;
  max_ms_ = std::max(max_ms_, time_ms);
}

double LatencyHistogram::quantile(double probability) const {
  const auto wanted =
      static_cast<std::size_t>(std::ceil(probability * static_cast<double>(count_)));
  std::size_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= wanted && seen > 0) {
      return std::min(kSmallest_ms * std::exp(kLogGrowth * static_cast<double>(bin)), max_ms_);
    }
  }
  return 0.0;
}

}  // namespace hymm::core
