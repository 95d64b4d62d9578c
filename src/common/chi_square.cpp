#include "common/chi_square.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace hymm::core {

double chiSquareQuantile(double probability, int dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double chiSquareCdf(double value, int dof) {
  return value <= 0.0 ? 0.0 : boost::math::cdf(boost::math::chi_squared(dof), value);
}

}  // namespace hymm::core
