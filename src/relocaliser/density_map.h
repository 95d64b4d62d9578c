#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "perception/observation.h"
#include "relocaliser/local_map.h"
#include "relocaliser/particle_kernels.h"

namespace hymm::core {

/// How an observation is weighed against the map.
struct DensityConfig {
  /// Share of the observations that are of nothing in the map: passers-by, new or missed landmarks.
  double clutter_share = 0.3;
  /// Observations' errors are taken to be at least this large: what the landmark's shape and the
  /// motion during a scan add.
  double min_deviation_m = 0.15;

  void describe(ConfigSchema& schema);
};

/// An observation as the kernels take it, with the deviation of its place.
struct ObservedPoint {
  Eigen::Vector2f p_base_point = Eigen::Vector2f::Zero();
  double deviation_m = 0.0;  ///< the larger of along and across the line of sight, rounded up
  double range_m = 0.0;
};

/// Beyond these deviations a landmark adds nothing that clutter does not.
inline constexpr double kDensityReach = 4.0;

/// The greater eigenvalue of a covariance.
double greatestVariance(const Eigen::Matrix2d& P);

/// Density of observations that are of nothing in the map.
double clutterPerM2(std::size_t points, double view_m2, const DensityConfig& config);

/// The next power of 1.3 (metres): deviations are rounded up so that few tables serve all.
double roundedUpDeviation(double deviation_m);

/// Those of the observations that are finite.
std::vector<ObservedPoint> observedPoints(const ObservationSet& set, double min_deviation_m);

/// Log density of where observations fall, no matter of which landmark they are: landmarks and
/// clutter together, on a grid in the local frame, one table for each class of the observations'
/// accuracy. What is added for an observation is
///   log(1 + sum_j N(point; landmark_j, P_j + R) / clutter density),
/// so that one that fits nothing costs nothing against clutter.
class DensityMap {
 public:
  /// Of `landmarks` for `points`, of which each is clutter with `clutter_share`, spread over
  /// `view_m2`.
  DensityMap(const std::vector<LocalLandmark>& landmarks, const std::vector<ObservedPoint>& points,
             double view_m2, const DensityConfig& config);

  DensityMap(const DensityMap&) = delete;
  DensityMap& operator=(const DensityMap&) = delete;

  const LookupGrid& grid() const { return grid_; }
  /// One for each of `points`; valid as long as the map lives.
  const std::vector<LookupPoint>& lookups() const { return lookups_; }
  /// What is added for `points[point]` where it falls on this place.
  double logValueAt(std::size_t point, const Eigen::Vector2d& p_local_point) const;
  double cell_m() const { return 1.0 / static_cast<double>(grid_.cells_per_m); }

 private:
  void addLandmark(const LocalLandmark& landmark, double variance_m2, double per_clutter,
                   std::vector<float>& table, std::vector<std::size_t>& touched) const;

  LookupGrid grid_;
  std::vector<std::vector<float>> tables_;
  std::vector<LookupPoint> lookups_;
};

/// The sum over `points` of what DensityMap adds for them, for one pose, without tables.
double logLikelihoodAt(const Pose2& pose, const std::vector<LocalLandmark>& landmarks,
                       const std::vector<ObservedPoint>& points, double view_m2,
                       const DensityConfig& config);

}  // namespace hymm::core
