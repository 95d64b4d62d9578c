#pragma once

#include <optional>
#include <vector>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/resumption.h"
#include "cekf/scan_associator.h"
#include "cekf/vehicle_state.h"
#include "perception/observation.h"

namespace hymm::core {

/// The update that closes a loop once another filter has found the vehicle: its path tells which
/// landmark each observation is of, and where to linearise; what the filter learns, it learns from
/// the observations and its own covariances alone.
class PathClosing {
 public:
  /// `at_first_estimates`: the covariance belongs to the places at which Jacobians are taken.
  PathClosing(const ResumptionConfig& config, bool at_first_estimates);

  /// What to close with, or an empty association if too little is plain.
  struct Closing {
    ScanAssociation association;
    UpdateOutcome update;
    double chi_square = 0.0;
    double limit = 0.0;
    double inflation = 1.0;

    int pairs() const { return static_cast<int>(association.measurements.size()); }
    bool accepted() const { return chi_square <= limit; }
  };

  /// Pairs the observations of `set` with landmarks as seen from `T_map_base`, where that leaves no
  /// doubt. Activates those landmarks.
  ScanAssociation associate(const ObservationSet& set, const Pose2& T_map_base,
                            const VehicleState& vehicle, const LandmarkRegistry& registry,
                            CompressedEkf& filter) const;

  /// Closes with what is plain at `T_map_base`: all pairs in one update, iterated from there. Not
  /// accepted if the joint innovation is beyond its gate even with the pose's covariance taken
  /// most_inflation times; the filter is then spoilt. Nothing if fewer than least_pairs are plain.
  std::optional<Closing> tryClose(const ObservationSet& set, const Pose2& T_map_base,
                                  VehicleState& vehicle, LandmarkRegistry& registry,
                                  CompressedEkf& filter) const;

 private:
  using Measurements = std::vector<SparseMeasurement>;

  /// An observation taken to be of a landmark.
  struct Pair {
    Observation sighting;
    SparseMeasurement measurement;
    double distance_m = 0.0;
  };

  std::optional<Pair> tryPair(const Observation& observation, const Pose2& T_map_base,
                              const SensorPlacement& sensor, const LandmarkRegistry& registry,
                              CompressedEkf& filter) const;
  std::optional<Pair> pairWith(const RegisteredLandmark& landmark, const Observation& observation,
                               const Pose2& T_map_base, const SensorPlacement& sensor,
                               CompressedEkf& filter) const;
  Measurements linearised(const ScanAssociation& association, const ObservationSet& set,
                          const Eigen::VectorXd& vehicle_at, const Eigen::VectorXd* landmarks_at,
                          const VehicleState& vehicle, const CompressedEkf& filter) const;
  Measurements iterated(const ScanAssociation& association, const ObservationSet& set,
                        const Pose2& T_map_base, VehicleState& vehicle, LandmarkRegistry& registry,
                        CompressedEkf& filter) const;
  void relineariseAt(const ScanAssociation& association, const Eigen::VectorXd& vehicle_at,
                     const Eigen::VectorXd* landmarks_at, VehicleState& vehicle,
                     LandmarkRegistry& registry, CompressedEkf& filter) const;

  ResumptionConfig config_;
  bool at_first_estimates_;
};

}  // namespace hymm::core
