#include "door_planner/side_bounds.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

/// Calls `visit(side, covariance)` with the vector of each side and its covariance (18).
template <class Visitor>
void visitSides(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance,
                Visitor&& visitor) {
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    Eigen::Matrix<double, 2, 6> H = Eigen::Matrix<double, 2, 6>::Zero();
    H.block<2, 2>(0, 2 * k) = -Eigen::Matrix2d::Identity();
    H.block<2, 2>(0, 2 * next) = Eigen::Matrix2d::Identity();
    const Eigen::Vector2d side = corners[std::size_t(next)] - corners[std::size_t(k)];
    visitor(side, Eigen::Matrix2d(H * covariance * H.transpose()));
  }
}

}  // namespace

double sideVectorBound(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance) {
  double share = 0.0;
  visitSides(corners, covariance, [&](const Eigen::Vector2d& side, const Eigen::Matrix2d& P) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(P, Eigen::EigenvaluesOnly);
    share = std::max(share, std::sqrt(std::max(0.0, solver.eigenvalues()[1])) / side.norm());
  });
  return 1.0 + share;
}

double sideLengthBound(const Corners& corners, const Eigen::Matrix<double, 6, 6>& covariance) {
  double share = 0.0;
  visitSides(corners, covariance, [&](const Eigen::Vector2d& side, const Eigen::Matrix2d& P) {
    const Eigen::Vector2d along = side.normalized();
    share = std::max(share, std::sqrt(std::max(0.0, along.dot(P * along))) / side.norm());
  });
  return 1.0 + share;
}

}  // namespace hymm::core
