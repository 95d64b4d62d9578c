#pragma once

#include <array>

#include <Eigen/Core>

#include "perception/perception_config.h"

namespace hymm::core {

/// What a scan tells of a shape that may be a trunk. Angles from the middle between its outermost
/// hits, positive with growing beam index. Each edge of the shape lies between its outermost hit
/// and the next beam that is known to miss it.
struct TrunkEvidence {
  static constexpr int kMaxHits = 32;

  int hits = 0;
  std::array<double, kMaxHits> offsets_rad;  ///< of the hits
  std::array<double, kMaxHits> ranges_m;
  double nearest_m = 0.0;        ///< of the ranges
  double half_extent_rad = 0.0;  ///< of the outermost hits from the middle
  double lower_gap_rad = 0.0;    ///< from the first hit to the miss before it
  double upper_gap_rad = 0.0;    ///< from the last hit to the miss after it
};

/// A circle fitted to a shape. State: range of the centre [m], bearing of the centre from the
/// evidence's middle [rad], diameter [m].
struct TrunkEstimate {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double chi_square = 0.0;  ///< of the ranges against the best circle, hits - 1 degrees of freedom
};

/// Mean and covariance of the circle, given the evidence: the posterior for edges that lie
/// anywhere within their gaps and Gaussian ranges (doc/perception.md, "The fit"). It holds for a
/// single hit as for many, and has no bias to first order in the beam spacing. `chi_square` is
/// infinite if no circle has these edges.
TrunkEstimate fitTrunk(const TrunkEvidence& evidence, const LaserNoise& noise,
                       double surface_deviation);

}  // namespace hymm::core
