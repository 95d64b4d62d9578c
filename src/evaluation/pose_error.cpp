#include "evaluation/pose_error.h"

#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "evaluation/rigid_alignment.h"

namespace hymm::core {
namespace {

/// Squared error in units of the covariance; nothing where that is not positive definite.
std::optional<double> normalisedSquare(const Eigen::Vector3d& error, const Eigen::Matrix3d& P) {
  const Eigen::LLT<Eigen::Matrix3d> cholesky(P);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return error.dot(cholesky.solve(error));
}

}  // namespace

std::optional<PoseErrors> computePoseErrors(const std::vector<UncertainPose>& poses,
                                            const Trajectory& truth, const TimeWindow& window) {
  PoseErrors errors;
  ConsistencySum nees;
  RigidAlignment alignment;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> pairs;  // estimate, truth
  std::vector<double> distances;
  double squared_heading = 0.0;
  for (const auto& [estimate, covariance] : poses) {
    if (!window.contains(estimate.time_s)) continue;
    const std::optional<Pose2> true_pose = truth.at(estimate.time_s);
    if (!true_pose) {
      ++errors.without_truth;
      continue;
    }
    const Eigen::Vector2d p = estimate.pose.position() - true_pose->position();
    const double heading_rad = wrapAngle(estimate.pose.yaw_rad - true_pose->yaw_rad);
    distances.push_back(p.norm());
    squared_heading += heading_rad * heading_rad;
    pairs.emplace_back(estimate.pose.position(), true_pose->position());
    alignment.add(pairs.back().first, pairs.back().second);
    if (const auto square = normalisedSquare({p.x(), p.y(), heading_rad}, covariance)) {
      nees.add(*square, 3);
    }
  }
  if (pairs.empty()) return std::nullopt;

  const Pose2 T = alignment.T_to_from();
  std::vector<double> aligned;
  aligned.reserve(pairs.size());
  for (const auto& [estimated, actual] : pairs) aligned.push_back((T * estimated - actual).norm());
  errors.heading_rmse_rad = std::sqrt(squared_heading / static_cast<double>(pairs.size()));
  errors.T_truth_map = T;
  errors.position_m = errorStatistics(std::move(distances));
  errors.aligned_position_m = errorStatistics(std::move(aligned));
  errors.nees = nees.result();
  return errors;
}

Trajectory inFrameOf(const Pose2& T_world_map, const Trajectory& truth) {
  const Pose2 T_map_world = inverse(T_world_map);
  std::vector<StampedPose> poses = truth.poses();
  for (StampedPose& pose : poses) pose.pose = T_map_world * pose.pose;
  return Trajectory(std::move(poses));
}

}  // namespace hymm::core
