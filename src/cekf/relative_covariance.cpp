#include "cekf/relative_covariance.h"

#include <algorithm>

namespace hymm::core {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr std::size_t kMostLandmarks = 12;  // beyond, the mean of their errors hardly changes
constexpr std::size_t kFewestSeen = 2;      // that fix a rigid motion
constexpr double kSmallestSpread_m2 = 1e-6;

/// J * v: v turned by a quarter to the left.
Vector2d turned(const Vector2d& v) { return {-v.y(), v.x()}; }

std::vector<int> nearestOf(const CompressedEkf& filter, std::vector<int> slots) {
  const Vector2d position = filter.vehicle().head<2>();
  const auto count = std::min(slots.size(), kMostLandmarks);
  const auto distance2 = [&](int slot) { return (filter.landmark(slot) - position).squaredNorm(); };
  std::partial_sort(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count), slots.end(),
                    [&](int a, int b) { return distance2(a) < distance2(b); });
  slots.resize(count);
  return slots;
}

MatrixXd jointCovariance(const CompressedEkf& filter, const std::vector<int>& slots) {
  const auto n = static_cast<Eigen::Index>(slots.size());
  MatrixXd joint(3 + 2 * n, 3 + 2 * n);
  joint.topLeftCorner<3, 3>() = filter.vehicleCovariance().topLeftCorner<3, 3>();
  if (n == 0) return joint;
  joint.bottomRightCorner(2 * n, 2 * n) = filter.jointCovariance(slots);
  for (Eigen::Index i = 0; i < n; ++i) {
    joint.block<3, 2>(0, 3 + 2 * i) =
        filter.vehicleLandmarkCovariance(slots[static_cast<std::size_t>(i)]).topRows<3>();
  }
  joint.bottomLeftCorner(2 * n, 3) = joint.topRightCorner(3, 2 * n).transpose();
  return joint;
}

}  // namespace

Matrix3d relativeCovariance(const Vector2d& position, const std::vector<Vector2d>& landmarks,
                            const MatrixXd& joint) {
  if (landmarks.empty()) return joint.topLeftCorner<3, 3>();
  const auto n = static_cast<double>(landmarks.size());
  Vector2d centre = Vector2d::Zero();
  for (const Vector2d& landmark : landmarks) centre += landmark / n;
  double spread_m2 = 0.0;
  for (const Vector2d& landmark : landmarks) spread_m2 += (landmark - centre).squaredNorm();
  const bool tells_turn = spread_m2 > kSmallestSpread_m2;

  // Errors e_i of landmarks at distance d_i from their centre fit best to the shift t = mean(e_i)
  // and the turn w = sum((J d_i)' e_i) / sum(|d_i|^2). What is left of the pose's error is linear
  // in all errors: e_p - t - w * J (p - centre), and e_yaw - w.
  Eigen::Matrix<double, 3, Eigen::Dynamic> left =
      Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, joint.cols());
  left.leftCols<3>().setIdentity();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    auto of_landmark = left.middleCols<2>(static_cast<Eigen::Index>(3 + 2 * i));
    of_landmark.topRows<2>() = -Eigen::Matrix2d::Identity() / n;
    if (!tells_turn) continue;
    const Eigen::RowVector2d turn = turned(landmarks[i] - centre).transpose() / spread_m2;
    of_landmark.topRows<2>() -= turned(position - centre) * turn;
    of_landmark.row(2) = -turn;
  }
  const Matrix3d covariance = left * joint * left.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

Matrix3d relativeCovariance(const CompressedEkf& filter, const std::vector<int>& seen) {
  const std::vector<int> slots =
      nearestOf(filter, seen.size() >= kFewestSeen ? seen : filter.activeLandmarks());
  std::vector<Vector2d> landmarks;
  for (const int slot : slots) landmarks.push_back(filter.landmark(slot));
  return relativeCovariance(filter.vehicle().head<2>(), landmarks, jointCovariance(filter, slots));
}

}  // namespace hymm::core
