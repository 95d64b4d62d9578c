#include "simulation/terrain.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hymm::core {
namespace {

constexpr double kShortestStep_m = 0.02;  // along a beam: how exactly it meets the ground

double bell(const Terrain::Hill& hill, const Eigen::Vector2d& point) {
  const double distance = (point - hill.centre).norm() / hill.radius_m;
  return hill.height_m * std::exp(-0.5 * distance * distance);
}

}  // namespace

Terrain::Terrain(std::vector<Hill> hills, const Eigen::Vector2d& datum) : hills_(std::move(hills)) {
  datum_m_ = sum(datum);
  // A bell is steepest at its radius, by exp(-1/2) of height over radius.
  for (const Hill& hill : hills_) {
    steepest_ += std::exp(-0.5) * std::abs(hill.height_m) / hill.radius_m;
  }
}

double Terrain::sum(const Eigen::Vector2d& point) const {
  double height = 0.0;
  for (const Hill& hill : hills_) height += bell(hill, point);
  return height;
}

double Terrain::height(const Eigen::Vector2d& point) const { return sum(point) - datum_m_; }

Eigen::Vector2d Terrain::slope(const Eigen::Vector2d& point) const {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  for (const Hill& hill : hills_) {
    slope -= bell(hill, point) / (hill.radius_m * hill.radius_m) * (point - hill.centre);
  }
  return slope;
}

double Terrain::stretch(const Pose2& pose) const {
  const Eigen::Vector2d heading(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  return std::hypot(1.0, slope(pose.position()).dot(heading));
}

Eigen::Isometry3d Terrain::standing(const Pose2& pose) const {
  const Eigen::Vector2d heading(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  const Eigen::Vector2d g = slope(pose.position());
  const Eigen::Vector3d up = Eigen::Vector3d(-g.x(), -g.y(), 1.0).normalized();
  const Eigen::Vector3d forward =
      Eigen::Vector3d(heading.x(), heading.y(), g.dot(heading)).normalized();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << forward, up.cross(forward), up;
  T.translation() << pose.x_m, pose.y_m, height(pose.position());
  return T;
}

std::optional<Terrain::GroundHit> Terrain::meet(const Beam& beam, double plan_range_m) const {
  if (isLevel()) return std::nullopt;
  // The height over the ground cannot shrink faster than this, so that steps of that size do not
  // pass through it.
  const double fastest = std::abs(beam.climb) + steepest_;
  double along = 0.0;
  while (along <= plan_range_m) {
    const Eigen::Vector2d point = beam.origin + along * beam.direction;
    const double over = beam.height_m + along * beam.climb - height(point);
    if (over <= 0.0) {
      const Eigen::Vector2d g = slope(point);
      const double into = std::abs(beam.climb - g.dot(beam.direction));
      return GroundHit{along, into / (beam.stretch * std::sqrt(1.0 + g.squaredNorm()))};
    }
    along += std::max(kShortestStep_m, over / fastest);
  }
  return std::nullopt;
}

Terrain Terrain::transformed(const Pose2& T_parent_child) const {
  Terrain moved = *this;
  for (Hill& hill : moved.hills_) hill.centre = T_parent_child * hill.centre;
  return moved;
}

}  // namespace hymm::core
