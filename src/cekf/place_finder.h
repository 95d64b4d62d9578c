#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "cekf/constellation_place.h"
#include "cekf/landmark_registry.h"
#include "cekf/observation_model.h"
#include "perception/observation.h"

namespace hymm::core {

/// Finds a vehicle again whose heading has become too uncertain for a filter: after a gap in the
/// recording while it drove, say. What a scan then would be associated with is decided by where the
/// linearisation happens to lead. Instead, the scan as a whole is looked for among all landmarks.
class PlaceFinder {
 public:
  PlaceFinder(const PlaceFindingConfig& config, const LandmarkConfig& landmarks)
      : config_(config), confirm_observations_(landmarks.confirm_observations) {}

  /// Whether no scan was explained lately, and the heading is less certain, relative to the
  /// landmarks seen last, than measurements can be linearised for. Makes these landmarks active.
  /// Never without landmarks, or where the observations tell which one they are of.
  bool isLost(const ObservationSet& set, const LandmarkRegistry& registry, CompressedEkf& filter);

  /// The vehicle's pose, and by observation its landmark's slot, or ConstellationPlace::kNone.
  /// Looks at once, and then now and then: the less often the more landmarks there are. A set of
  /// too few observations to tell a place does not count: the next one is looked at.
  std::optional<ConstellationPlace> find(const ObservationSet& set, const SensorPlacement& sensor,
                                         const LandmarkRegistry& registry,
                                         const CompressedEkf& filter);

  /// Landmarks have explained the scan of this time.
  void tellExplained(double time_s) { explained_s_ = time_s; }

  /// Whether nothing is to be made of a scan without a place: for some time after the vehicle was
  /// lost a better scan may come. After that a new part of the map begins.
  bool waits(double time_s) const {
    return lost_since_s_ && time_s - *lost_since_s_ < config_.hold_s;
  }

  /// What the pose is taken to be uncertain by, around a place that was found, before the scan's
  /// measurements tell: hardly anything is known.
  static Eigen::Matrix3d priorCovariance();

 private:
  static std::vector<int> seenLast(const LandmarkRegistry& registry);

  PlaceFindingConfig config_;
  int confirm_observations_;
  double explained_s_ = -std::numeric_limits<double>::infinity();
  std::optional<double> lost_since_s_;
  double next_search_s_ = -std::numeric_limits<double>::infinity();  ///< while lost
};

}  // namespace hymm::core
