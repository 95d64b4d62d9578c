#pragma once

#include <cmath>

#include "common/random.h"

namespace hymm::core {

/// An error of deviation 1 that persists over a correlation time (a stationary first-order
/// Gauss-Markov process).
class CorrelatedNoise {
 public:
  CorrelatedNoise(double correlation_time_s, RandomGenerator& generator)
      : correlation_time_s_(correlation_time_s), value_(sampleNormal(generator, 1.0)) {}

  double value() const { return value_; }

  void advance(double duration_s, RandomGenerator& generator) {
    const double kept = std::exp(-duration_s / correlation_time_s_);
    value_ = kept * value_ + sampleNormal(generator, std::sqrt(1.0 - kept * kept));
  }

 private:
  double correlation_time_s_;
  double value_;
};

}  // namespace hymm::core
