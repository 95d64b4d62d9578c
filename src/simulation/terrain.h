#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/pose2.h"

namespace hymm::core {

/// A ray as it goes over the ground: straight in plan, climbing evenly.
struct Beam {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< in plan, of length 1
  double height_m = 0.0;                                 ///< of its origin
  double climb = 0.0;                                    ///< metres up for each metre in plan
  double stretch = 1.0;                                  ///< metres of ray for each metre in plan
};

/// Ground that rises and falls: a sum of round hills and hollows. Level without any.
class Terrain {
 public:
  struct Hill {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double height_m = 0.0;  ///< negative for a hollow
    double radius_m = 1.0;  ///< where it is steepest
  };

  Terrain() = default;
  /// Heights count from the ground at `datum`.
  Terrain(std::vector<Hill> hills, const Eigen::Vector2d& datum);

  bool isLevel() const { return hills_.empty(); }
  double height(const Eigen::Vector2d& point) const;
  /// Metres up for each metre along x and along y.
  Eigen::Vector2d slope(const Eigen::Vector2d& point) const;
  /// Metres of ground for each metre in plan, along a heading.
  double stretch(const Pose2& pose) const;
  /// Of something that stands at `pose` in plan: x along its heading, z upright on the ground.
  Eigen::Isometry3d standing(const Pose2& pose) const;

  struct GroundHit {
    double plan_range_m;
    double incidence_cosine;  ///< between the beam and the ground's normal
  };
  /// Where the beam first comes down on the ground within `plan_range_m`.
  std::optional<GroundHit> meet(const Beam& beam, double plan_range_m) const;

  Terrain transformed(const Pose2& T_parent_child) const;

 private:
  double sum(const Eigen::Vector2d& point) const;

  std::vector<Hill> hills_;
  double datum_m_ = 0.0;
  double steepest_ = 0.0;  ///< no slope is steeper
};

}  // namespace hymm::core
