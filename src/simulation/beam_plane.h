#pragma once

#include "simulation/terrain.h"

namespace hymm::core {

/// The plane that a laser sweeps: level, or tilted with the vehicle on a slope.
class BeamPlane {
 public:
  /// Level. Meant to be converted to: on level ground a pose in plan says all.
  BeamPlane(const Pose2& T_map_laser) : T_map_laser_(T_map_laser) {}  // NOLINT

  /// Of a laser `height_m` above the plane that the vehicle stands on.
  BeamPlane(const Terrain& terrain, const Pose2& T_map_base, const Pose2& T_base_laser,
            double height_m);

  Beam beam(double bearing_rad) const;

  /// In plan.
  const Pose2& T_map_laser() const { return T_map_laser_; }

 private:
  Pose2 T_map_laser_;
  bool is_level_ = true;
  Eigen::Isometry3d T_space_ = Eigen::Isometry3d::Identity();  ///< of the laser in map
};

}  // namespace hymm::core
