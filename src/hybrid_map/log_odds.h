#pragma once

#include <cmath>

namespace hymm::core {

/// (1) in its odds form: the log-odds of a cell grow by the logarithm of the ratio in which an
/// observation is likelier of an occupied cell than of a free one.
inline double logOddsOf(double probability) { return std::log(probability / (1.0 - probability)); }
inline double probabilityOf(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

}  // namespace hymm::core
