#include "simulation/beam_plane.h"

#include <cmath>

namespace hymm::core {

BeamPlane::BeamPlane(const Terrain& terrain, const Pose2& T_map_base, const Pose2& T_base_laser,
                     double height_m)
    : T_map_laser_(T_map_base * T_base_laser), is_level_(terrain.isLevel()) {
  if (is_level_) return;
  Eigen::Isometry3d T_base_laser_space = Eigen::Isometry3d::Identity();
  T_base_laser_space.translation() << T_base_laser.x_m, T_base_laser.y_m, height_m;
  T_base_laser_space.rotate(Eigen::AngleAxisd(T_base_laser.yaw_rad, Eigen::Vector3d::UnitZ()));
  T_space_ = terrain.standing(T_map_base) * T_base_laser_space;
  const Eigen::Vector3d forward = T_space_.linear().col(0), place = T_space_.translation();
  T_map_laser_ = {place.x(), place.y(), std::atan2(forward.y(), forward.x())};
}

Beam BeamPlane::beam(double bearing_rad) const {
  if (is_level_) {
    const double angle = T_map_laser_.yaw_rad + bearing_rad;
    return {T_map_laser_.position(), {std::cos(angle), std::sin(angle)}, 0.0, 0.0, 1.0};
  }
  const Eigen::Vector3d ray =
      T_space_.linear() * Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0);
  const double in_plan = ray.head<2>().norm();
  return {T_space_.translation().head<2>(), ray.head<2>() / in_plan, T_space_.translation().z(),
          ray.z() / in_plan, 1.0 / in_plan};
}

}  // namespace hymm::core
