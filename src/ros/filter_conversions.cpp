#include "ros/filter_conversions.h"

#include "ros/pose_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

FilterPose toMessage(const core::PoseEstimate& estimate, const std::string& frame_id) {
  FilterPose message;
  message.header.stamp = toRosTime(estimate.time_s);
  message.header.frame_id = frame_id;
  message.pose = toMessage(estimate.T_map_base, estimate.covariance);
  message.map_version = estimate.map_version;
  message.sensor = toPoseMessage(estimate.T_base_sensor);
  message.range_offset = estimate.range_offset_m;
  Eigen::Map<RowMajor3>(message.relative_covariance.data()) = estimate.relative_covariance;
  for (const core::SweepMotion::Piece& piece : estimate.sweep.pieces) {
    SweepPiece& part = message.sweep.emplace_back();
    part.begin = piece.from_s;
    part.forward = piece.forward_mps;
    part.lateral = piece.lateral_mps;
    part.yaw_rate = piece.yaw_rate_radps;
  }
  return message;
}

core::FilterCounters countersOf(const FilterPose& message) {
  core::FilterCounters counters;
  counters.version = message.map_version;
  counters.resets = message.resets;
  return counters;
}

core::PoseEstimate fromMessage(const FilterPose& message) {
  core::PoseEstimate estimate;
  estimate.time_s = message.header.stamp.toSec();
  estimate.T_map_base = fromMessage(message.pose.pose);
  estimate.covariance = planarCovariance(message.pose);
  estimate.map_version = message.map_version;
  estimate.T_base_sensor = fromMessage(message.sensor);
  estimate.range_offset_m = message.range_offset;
  estimate.relative_covariance = Eigen::Map<const RowMajor3>(message.relative_covariance.data());
  for (const SweepPiece& part : message.sweep) {
    estimate.sweep.pieces.push_back({part.begin, part.forward, part.lateral, part.yaw_rate});
  }
  return estimate;
}

FilterHealth toMessage(const core::FilterHealth& health, const std::string& frame_id) {
  FilterHealth message;
  message.header.stamp = toRosTime(health.time_s);
  message.header.frame_id = frame_id;
  message.nis = health.nis;
  message.dof = static_cast<std::uint32_t>(health.dof);
  message.ambiguity = health.ambiguity;
  message.unexplained = health.unexplained;
  message.missed = health.missed;
  message.confirmed_expected = static_cast<std::uint32_t>(health.confirmed_expected);
  message.confirmed_missed = static_cast<std::uint32_t>(health.confirmed_missed);
  message.position_deviation = health.position_deviation_m;
  message.heading_deviation = health.heading_deviation_rad;
  message.latency_ms = health.latency_ms;
  return message;
}

core::FilterHealth fromMessage(const FilterHealth& message) {
  core::FilterHealth health;
  health.time_s = message.header.stamp.toSec();
  health.nis = message.nis;
  health.dof = static_cast<int>(message.dof);
  health.ambiguity = message.ambiguity;
  health.unexplained = message.unexplained;
  health.missed = message.missed;
  health.confirmed_expected = static_cast<int>(message.confirmed_expected);
  health.confirmed_missed = static_cast<int>(message.confirmed_missed);
  health.position_deviation_m = message.position_deviation;
  health.heading_deviation_rad = message.heading_deviation;
  health.latency_ms = message.latency_ms;
  return health;
}

}  // namespace hymm
