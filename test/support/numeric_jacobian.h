#pragma once

#include <Eigen/Core>

namespace hymm::test {

/// Derivative of a vector function at `x` by central differences. For smooth functions of size
/// about 1 it is good to about 1e-9.
template <typename Function>
Eigen::MatrixXd numericJacobian(const Function& function, const Eigen::VectorXd& x,
                                double step = 1e-5) {
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Eigen::VectorXd h = step * Eigen::VectorXd::Unit(x.size(), i);
    const Eigen::VectorXd difference = function(x + h) - function(x - h);
    if (i == 0) J.resize(difference.size(), x.size());
    J.col(i) = difference / (2.0 * step);
  }
  return J;
}

}  // namespace hymm::test
