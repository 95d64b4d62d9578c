#pragma once

#include <Eigen/Core>

namespace hymm::core {

/// The vehicle's part of a filter's state has at most this many states, so what is only about the
/// vehicle needs no memory from the heap.
constexpr int kMaxVehicleStates = 16;

using VehicleVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxVehicleStates, 1>;
using VehicleMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxVehicleStates, kMaxVehicleStates>;
/// Jacobian of something with two coordinates by the vehicle's states.
using VehicleJacobian = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxVehicleStates>;

/// M * J' for the Jacobian J of a motion. Most of J is zero, as the errors and the calibration of a
/// vehicle change by themselves alone; products with zeros are left out.
template <class Left>
auto timesMotionTransposed(const Left& M, const VehicleMatrix& J) {
  using Product = Eigen::Matrix<double, Left::RowsAtCompileTime, Eigen::Dynamic, 0,
                                Left::MaxRowsAtCompileTime, kMaxVehicleStates>;
  Product product = Product::Zero(M.rows(), J.rows());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      if (J(i, k) != 0.0) product.col(i) += J(i, k) * M.col(k);
    }
  }
  return product;
}

}  // namespace hymm::core
