#include "pipeline/grid_mapper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "common/cpu_timer.h"
#include "perception/swept_scan.h"

namespace hymm::core {
namespace {

constexpr const char* kOnlyForLocalising =
    "the map was loaded only for localising, and is not extended";

}  // namespace

PosedScan posedScan(const LaserScan& scan, const PoseEstimate& pose, double min_range_m) {
  PosedScan posed;
  posed.scan = sweptScan(scan, pose.sweep, pose.T_base_sensor);
  const auto offset_m = static_cast<float>(pose.range_offset_m);
  for (float& range_m : posed.scan.ranges_m) {
    range_m -= offset_m;
    if (static_cast<double>(range_m) < min_range_m) {
      range_m = std::numeric_limits<float>::quiet_NaN();
    }
  }
  posed.T_map_laser = pose.T_map_base * pose.T_base_sensor;
  posed.map_version = pose.map_version;
  // An error of the heading shifts the sensor, which stands at `arm` from base_link.
  const Eigen::Vector2d arm = posed.T_map_laser.position() - pose.T_map_base.position();
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topRightCorner<2, 1>() << -arm.y(), arm.x();
  const Eigen::Matrix3d C = J * pose.relative_covariance * J.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(C.topLeftCorner<2, 2>(),
                                                            Eigen::EigenvaluesOnly);
  posed.pose_deviation_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  posed.heading_deviation_rad = std::sqrt(std::max(0.0, C(2, 2)));
  return posed;
}

PosedScan GridMapper::posed(const LaserScan& scan, const PoseEstimate& pose) const {
  return posedScan(scan, pose, min_range_m_);
}

MappedOutcome GridMapper::process(const MappedScan& step) {
  const CpuTimer timer(cpu_s_);
  MappedOutcome outcome;
  const MapOutcome landmarks = follow(step);
  outcome.follows = landmarks.accepted;
  outcome.topology =
      step.map || !landmarks.change.created.empty() || !landmarks.change.retired.empty();
  if (!landmarks.accepted) {
    ++counts_.without_landmarks;
    outcome.reason = landmarks.reason;
  } else if (step.scan) {
    const PosedScan posed = this->posed(*step.scan, step.pose);
    if (agreement_due_.takeIfDue(step.pose.time_s)) {
      outcome.agreement = matcher_.agreement(map_, posed.scan, posed.T_map_laser);
    }
    const MapOutcome scan = insert(posed);
    outcome.written = scan.accepted;
    outcome.reason = scan.reason;
    if (!scan.accepted && use_ != MapUse::kLocalise) ++counts_.not_written;
  }
  return outcome;
}

MapOutcome GridMapper::follow(const MappedScan& step) {
  if (step.map) landmarks_ = step.map;
  if (use_ == MapUse::kLocalise) return followVersion(step.update.version);
  return step.map ? map_.apply(*step.map) : map_.apply(step.update);
}

/// While landmarks are fixed, nothing but the version changes.
MapOutcome GridMapper::followVersion(std::uint64_t version) {
  LandmarkUpdate nothing;
  nothing.since_version = map_.landmarkVersion();
  nothing.version = version;
  return map_.apply(nothing);
}

MapOutcome GridMapper::insert(const PosedScan& scan) {
  return use_ == MapUse::kExtend ? map_.insert(scan) : MapOutcome{false, kOnlyForLocalising, {}};
}

MapOutcome GridMapper::insert(const PropertySample& sample) {
  const CpuTimer timer(cpu_s_);
  if (use_ == MapUse::kLocalise) return {false, kOnlyForLocalising, {}};
  return map_.insert(sample);
}

void GridMapper::reset() {
  map_.reset();
  landmarks_.reset();
  use_ = MapUse::kExtend;
}

void GridMapper::loadState(std::string_view bytes, const std::string& name,
                           std::uint64_t landmark_version, MapUse use) {
  map_.loadState(bytes, name, landmark_version);
  landmarks_.reset();
  use_ = use;
}

std::vector<LtrTopology> GridMapper::topology() const {
  return map_.topology(landmarks_ ? *landmarks_ : LandmarkMap());
}

}  // namespace hymm::core
