#include "relocaliser/normal_table.h"

#include <cmath>

#include <boost/math/distributions/normal.hpp>

namespace hymm::core {

NormalTable::NormalTable() {
  const boost::math::normal normal;
  double sum_squares = 0.0;
  std::array<double, kSize> quantiles;
  for (std::size_t i = 0; i < kSize; ++i) {
    const double probability = (static_cast<double>(i) + 0.5) / static_cast<double>(kSize);
    quantiles[i] = boost::math::quantile(normal, probability);
    sum_squares += quantiles[i] * quantiles[i];
  }
  const double scale = 1.0 / std::sqrt(sum_squares / static_cast<double>(kSize));
  for (std::size_t i = 0; i < kSize; ++i) values_[i] = static_cast<float>(scale * quantiles[i]);
}

const NormalTable& NormalTable::instance() {
  static const NormalTable table;
  return table;
}

}  // namespace hymm::core
