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

/// How many rows of the Jacobian of a motion come before those that are diagonal: the pose depends
/// on all states of the vehicle, its errors and calibration change by themselves alone.
inline Eigen::Index rowsBeforeDiagonal(const VehicleMatrix& J) {
  for (Eigen::Index i = J.rows(); i > 0; --i) {
    for (Eigen::Index k = 0; k < J.cols(); ++k) {
      if (k != i - 1 && J(i - 1, k) != 0.0) return i;
    }
  }
  return 0;
}

/// M * J' for the Jacobian J of a motion.
template <class Left>
auto timesMotionTransposed(const Left& M, const VehicleMatrix& J) {
  using Product = Eigen::Matrix<double, Left::RowsAtCompileTime, Eigen::Dynamic, 0,
                                Left::MaxRowsAtCompileTime, kMaxVehicleStates>;
  const Eigen::Index n = J.rows(), full = rowsBeforeDiagonal(J);
  Product product(M.rows(), n);
  product.leftCols(full) = M.lazyProduct(J.topRows(full).transpose());
  for (Eigen::Index i = full; i < n; ++i) product.col(i) = J(i, i) * M.col(i);
  return product;
}

}  // namespace hymm::core
