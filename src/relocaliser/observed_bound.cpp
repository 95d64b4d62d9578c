#include "relocaliser/observed_bound.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The deviation of a place that may be anywhere: farther than any local map reaches.
constexpr double kAnywhere_m = 1e4;

Matrix3d turnBy(double yaw_rad) {
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0.0, 0.0, yaw_rad}.rotation();
  return turn;
}

}  // namespace

PosePrior moved(const PosePrior& prior, const Pose2& T_begin_end, const Matrix3d& covariance) {
  const Matrix3d turn = turnBy(prior.mean.yaw_rad);
  const Eigen::Vector2d way = turn.topLeftCorner<2, 2>() * T_begin_end.position();
  Matrix3d J = Matrix3d::Identity();
  J(0, 2) = -way.y();
  J(1, 2) = way.x();
  return {prior.mean * T_begin_end,
          J * prior.covariance * J.transpose() + turn * covariance * turn.transpose()};
}

Matrix3d raisedTo(const Matrix3d& covariance, const Matrix3d& bound) {
  const Eigen::LLT<Matrix3d> root(bound);
  if (root.info() != Eigen::Success) return covariance;
  const Matrix3d half = root.matrixL().solve(covariance);
  const Matrix3d in_units = root.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(0.5 * (in_units + in_units.transpose()));
  const Vector3d raised = axes.eigenvalues().cwiseMax(1.0);
  const Matrix3d back = root.matrixL() * axes.eigenvectors();
  return back * raised.asDiagonal() * back.transpose();
}

void ObservedBound::begin(const PosePrior& prior) {
  known_ = prior;
  of_landmarks_.setZero();
}

void ObservedBound::beginAnywhere() {
  constexpr double kAnywhere_m2 = kAnywhere_m * kAnywhere_m;
  const double any_heading_rad2 = kPi * kPi / 3.0;  // of one that is as likely as any other
  begin({{}, Vector3d(kAnywhere_m2, kAnywhere_m2, any_heading_rad2).asDiagonal()});
}

void ObservedBound::move(const Pose2& T_begin_end, const Matrix3d& covariance) {
  known_ = moved(known_, T_begin_end, covariance);
}

void ObservedBound::observe(const Pose2& pose, const Explanation& explanation) {
  // What was known turns with the vehicle, should another place be believed now.
  const Matrix3d turn = turnBy(pose.yaw_rad - known_.mean.yaw_rad);
  const Matrix3d before = turn * known_.covariance * turn.transpose();
  const Matrix3d gained = Matrix3d::Identity() + before * explanation.of_points;
  known_ = {pose, gained.inverse() * before};
  known_.covariance = 0.5 * (known_.covariance + known_.covariance.transpose()).eval();
  // With one landmark in view nothing follows of its error: the recursion alone bounds.
  const Eigen::FullPivLU<Matrix3d> lu(explanation.of_landmarks);
  of_landmarks_.setZero();
  if (lu.isInvertible()) of_landmarks_ = lu.inverse();
}

}  // namespace hymm::core
