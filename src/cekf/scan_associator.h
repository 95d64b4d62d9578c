#pragma once

#include <optional>
#include <vector>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "cekf/joint_compatibility.h"
#include "cekf/landmark_registry.h"
#include "cekf/lasting_errors.h"
#include "cekf/observation_model.h"
#include "perception/observation.h"

namespace hymm::core {

/// Which observations of a set belong to which landmarks.
struct ScanAssociation {
  static constexpr int kNone = -1;

  std::vector<int> slots;     ///< by observation: the landmark's slot, or kNone
  std::vector<bool> claimed;  ///< by observation: too near a landmark to be a new one
  std::vector<bool> ignored;  ///< by observation: without identity, where the set has identities
  std::vector<SparseMeasurement> measurements;  ///< of the observations with a landmark
  /// By measurement: the observation, as it is for the diameter and the lasting error that the
  /// filter holds.
  std::vector<Observation> sightings;
  /// Of the measurements, over chance; see logOdds(). Those by identity count as if they had none.
  double log_odds = 0.0;
  bool is_placed = true;  ///< false: it is not known where the vehicle is, and nothing was tried
  int ambiguous = 0;      ///< observations with two or more compatible landmarks
  bool complete = true;  ///< false: there was too much to choose from, and the search was cut short
};

/// Associates observations with landmarks: by identity where the sensor reads one, else by joint
/// compatibility over those that pass the individual gates. Activates the landmarks that it
/// considers.
class ScanAssociator {
 public:
  /// Measurements are linearised at the latest estimates; with `relinearise_m`, at the places that
  /// the landmarks' covariances belong to, which follow where an estimate has moved by more.
  explicit ScanAssociator(const AssociationConfig& config,
                          std::optional<double> relinearise_m = std::nullopt,
                          const LastingErrorConfig& lasting_errors = {});

  /// `more`: covariance that the vehicle's states are taken to have beyond the filter's.
  ScanAssociation associate(const ObservationSet& set, const SensorPlacement& sensor,
                            LandmarkRegistry& registry, CompressedEkf& filter,
                            const VehicleMatrix* more = nullptr) const;

  /// The association that `slots` tell, by observation, each kNone or the slot of a landmark; the
  /// measurements are near their landmarks.
  ScanAssociation associateAs(const std::vector<int>& slots, const ObservationSet& set,
                              const SensorPlacement& sensor, LandmarkRegistry& registry,
                              CompressedEkf& filter) const;
  /// Nothing is associated, and nothing is of a new landmark.
  static ScanAssociation associateNothing(const ObservationSet& set);

 private:
  struct Candidate {
    Pairing pairing;
    SparseMeasurement measurement;
    Observation sighting;
    double distance2 = 0.0;  ///< squared Mahalanobis distance of the innovation alone
  };

  /// Bound the work in a world denser than the parameters expect, or where the vehicle hardly knows
  /// where it is: landmarks that are looked at for an observation, which makes them active, and
  /// those of them that it may be of.
  static constexpr std::size_t kMaxConsidered = 64;
  static constexpr std::size_t kMaxCandidates = 5;

  /// Where an observation may find its landmarks.
  struct SearchCircle {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< map frame, m
    double own_reach_m = 0.0;  ///< from the centre to a landmark that is known exactly
  };

  SearchCircle searchCircle(const Observation& observation, const SensorPlacement& sensor,
                            const CompressedEkf& filter, const VehicleMatrix* more) const;
  /// Slots of the landmarks in the circle, ascending; of too many the nearest.
  std::vector<int> slotsIn(const SearchCircle& circle, const LandmarkRegistry& registry) const;
  bool isPlaceKnown(const Eigen::Matrix2d& S, double chance_density) const;
  /// The measurement of a landmark, which is made active. `sighting`: the observation, which
  /// becomes what it is for the landmark's diameter and the lasting error of its sightings.
  SparseMeasurement measure(Observation& sighting, const SensorPlacement& sensor,
                            RegisteredLandmark& landmark, CompressedEkf& filter) const;
  void associateByIdentity(const ObservationSet& set, const SensorPlacement& sensor,
                           LandmarkRegistry& registry, CompressedEkf& filter,
                           const VehicleMatrix* more, ScanAssociation& result) const;
  std::vector<Candidate> compatibleLandmarks(const ObservationSet& set,
                                             const SensorPlacement& sensor, int observation,
                                             LandmarkRegistry& registry, CompressedEkf& filter,
                                             const VehicleMatrix* more,
                                             ScanAssociation& result) const;
  std::optional<Candidate> candidate(const Observation& observation, const SensorPlacement& sensor,
                                     RegisteredLandmark& landmark, CompressedEkf& filter,
                                     const VehicleMatrix* more, bool& is_claimed) const;
  void chooseNearest(const std::vector<Candidate>& candidates, ScanAssociation& result) const;
  void chooseJointly(const std::vector<Candidate>& candidates, const CompressedEkf& filter,
                     const VehicleMatrix* more, ScanAssociation& result) const;

  AssociationConfig config_;
  LastingErrorModel lasting_errors_;
  std::optional<double> relinearise_m_;
  double individual_gate_;
  double wider_gate_;  ///< of that and the gate around which no new landmark starts
  double identity_gate_;
  double least_log_odds_;
  double rival_log_odds_;
  JointCompatibility joint_;
};

}  // namespace hymm::core
