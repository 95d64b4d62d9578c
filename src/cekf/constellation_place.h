#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "perception/observation.h"

namespace hymm::core {

/// What is seen from an unknown place, and where it may be.
struct SeenConstellation {
  struct Point {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
    double variance_m2 = 0.0;                            ///< along each axis
    LandmarkType type = LandmarkType::kUnknown;
  };
  std::vector<Point> seen;       ///< in the vehicle's axes
  std::vector<Point> landmarks;  ///< in the map; variances are among each other
  Pose2 expected;                ///< of the vehicle in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of that (x, y, yaw), m and rad
};

/// A place from which the landmarks look like that, and from no other one.
struct ConstellationPlace {
  static constexpr int kNone = -1;
  static constexpr int kFewestPairs = 3;

  Pose2 T_map_base;
  std::vector<int> landmarks;  ///< by what is seen: its landmark, or kNone
  int pairs = 0;
};

/// The one pose at which what is seen lies where landmarks are, wherever within four deviations of
/// the expected pose, turned in any way that these allow. Every pose at which two things seen that
/// are far apart lie at landmarks is looked at (of pairs of them, the widest). Let each thing seen
/// be in the map or not with the same odds: the pose's likelihood over that of all of it being
/// unmapped things anywhere has to make up for the share of the poses expected that it is, and to
/// exceed that of any other pose, by one over `coincidence`. Nothing otherwise, and if there are
/// more landmarks than can be looked through, or fewer than kFewestPairs things seen.
/// Deterministic.
std::optional<ConstellationPlace> findConstellationPlace(const SeenConstellation& question,
                                                         double coincidence);

}  // namespace hymm::core
