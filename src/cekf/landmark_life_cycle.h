#pragma once

#include <algorithm>
#include <limits>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "cekf/duplicate_search.h"
#include "cekf/landmark_map.h"
#include "cekf/landmark_registry.h"
#include "cekf/lasting_errors.h"
#include "cekf/scan_associator.h"
#include "cekf/tentative_landmarks.h"
#include "cekf/vehicle_state.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// How landmarks come into the state, are confirmed, missed, dropped, and fused with duplicates.
/// Owns what is known of them beside their estimates.
class LandmarkLifeCycle {
 public:
  struct Counts {
    std::size_t created = 0;
    std::size_t dropped = 0;
    std::size_t merged = 0;
    std::size_t slips = 0;  ///< of the vehicle, that older landmarks have told of
  };

  /// Landmarks that a scan should have shown and did not.
  struct Missed {
    int all = 0;
    int confirmed = 0;
  };

  explicit LandmarkLifeCycle(const CekfSlamConfig& config);

  /// Lets the measurements of landmarks that come into view depend on the lasting errors of their
  /// sightings, which begin here.
  void beginLastingErrors(const SensorPlacement& sensor, ScanAssociation& association,
                          CompressedEkf& filter);
  /// Forgets the lasting errors of sightings from elsewhere.
  void forgetLastingErrors(const SensorPlacement& sensor, CompressedEkf& filter);

  /// Notes what the associated observations say of their landmarks.
  void confirm(const ObservationSet& set, const ScanAssociation& association,
               CompressedEkf& filter);

  /// Lets observations without a landmark become tentative ones, and promotes those seen often
  /// enough into the state. Returns by observation the new landmark's slot, or kNone.
  /// `linearised_at`: the vehicle's position that the covariance belongs to.
  std::vector<int> create(const ObservationSet& set, const SensorPlacement& sensor,
                          const ScanAssociation& association, const Eigen::Vector2d& linearised_at,
                          CompressedEkf& filter);

  /// Landmarks that `scan` should have shown and did not lose odds of existence; those that lost
  /// too much are dropped.
  Missed miss(const LaserScan& scan, const ObservationSet& set, const SensorPlacement& sensor,
              const ScanAssociation& association, CompressedEkf& filter);

  /// Landmarks that are not dropped from now on; one that was merged stands for what it became.
  void pin(const std::unordered_set<int>& ids);

  /// Whether it was seen so often that it is surely there.
  bool isConfirmed(const RegisteredLandmark& landmark) const {
    return landmark.observations >= config_.confirm_observations;
  }

  /// Drops landmarks that were seen too seldom to be trusted and have been left behind.
  void dropUnconfirmed(double time_s, CompressedEkf& filter);

  /// Fuses landmarks of this scan with others that are the same object. Returns how far that moved
  /// an active landmark [m].
  double merge(const ScanAssociation& association, CompressedEkf& filter);

  /// Fuses landmarks around the vehicle with older ones that they turn out to be, together. Returns
  /// how far that moved an active landmark [m].
  double closeLoop(double time_s, VehicleState& vehicle, CompressedEkf& filter);

  /// Takes over the filter's positions of active landmarks.
  void refreshActive(const CompressedEkf& filter);
  /// Takes over where the last global update put the passive ones, with their deviations.
  void refreshSettled(const CompressedEkf& filter);
  /// Takes over the filter's positions of all landmarks within `radius_m`, active or not.
  void refreshNear(const Eigen::Vector2d& centre, double radius_m, const CompressedEkf& filter);

  void clear();

  /// Makes everything as it was. takeChanges() tells what is then different: landmarks made since
  /// as removed, and all others as changed.
  void goBackTo(const LandmarkLifeCycle& before);
  /// No landmark gets an id below `next_id` from now on.
  void skipIds(int next_id) { next_id_ = std::max(next_id_, next_id); }
  int nextId() const { return next_id_; }
  /// Another clock begins, `later_s` after the time reached so far: what was seen lies in the past
  /// by it, whatever the clock says. Nothing is half seen.
  void beginSession(double later_s);

  LandmarkRegistry& registry() { return registry_; }
  const LandmarkRegistry& registry() const { return registry_; }
  const std::vector<LandmarkMerge>& merges() const { return merges_; }

  /// What became of landmarks since the last call.
  struct Changes {
    std::vector<int> changed_ids, removed_ids;  ///< ascending
    std::vector<LandmarkMerge> merges;
  };
  Changes takeChanges();

  const Counts& counts() const { return counts_; }

  template <class Archive>
  void describeState(Archive& archive) {
    std::vector<std::pair<int, int>> merges;
    for (const LandmarkMerge& merge : merges_) merges.emplace_back(merge.from_id, merge.into_id);
    archive(registry_, diameters_, lasting_errors_, tentative_, searched_s_, merges, merges_taken_,
            changed_ids_, removed_ids_, unconfirmed_ids_, told_pins_, pinned_ids_, distinct_from_,
            scan_number_, next_id_);
    if constexpr (Archive::kReads) {
      merges_.clear();
      for (const auto& [from, into] : merges) merges_.push_back({from, into});
      archive.require(merges_taken_ <= merges_.size(), "it told of more merges than there were");
      for (const int id : unconfirmed_ids_) {
        archive.require(registry_.contains(id), "a landmark is to be confirmed that is not there");
      }
    }
  }

 private:
  bool isFarFromOthers(const Eigen::Vector2d& position) const;
  int promote(const Observation& observation, const ObservationSet& set,
              const SensorPlacement& sensor, const Eigen::Vector2d& linearised_at,
              CompressedEkf& filter);
  void appendTo(CompressedEkf& filter, Observation observation, const SensorPlacement& sensor,
                RegisteredLandmark& landmark);
  void noteNeighboursSeenTogether(const std::vector<int>& slots);
  bool areOneObject(const RegisteredLandmark& a, const RegisteredLandmark& b,
                    CompressedEkf& filter) const;
  bool areDistinct(int id_a, int id_b) const;
  bool isPlaceKnown(const RegisteredLandmark& landmark, const CompressedEkf& filter) const;
  void addSlip(const DuplicatesFound& found, CompressedEkf& filter);
  static std::vector<SparseMeasurement> samePlaces(
      const std::vector<DuplicateLandmarks>& duplicates, const CompressedEkf& filter);
  void relineariseAtOnePlace(const DuplicateLandmarks& pair, CompressedEkf& filter);
  double fuse(const std::vector<DuplicateLandmarks>& duplicates, CompressedEkf& filter);
  void takeOver(const RegisteredLandmark& gone, RegisteredLandmark& kept);
  void drop(int id, CompressedEkf& filter);
  void followMerges();

  LandmarkConfig config_;
  double large_correction_m_;
  bool at_first_estimates_;  ///< whether RegisteredLandmark::linearised_at counts
  double merge_gate_;
  double hit_log_odds_, miss_log_odds_;
  LandmarkRegistry registry_;
  DiameterStates diameters_;
  LastingErrorModel lasting_error_model_;
  LastingErrors lasting_errors_;
  TentativeLandmarks tentative_;
  DuplicateSearch duplicate_search_;
  double searched_s_ = -std::numeric_limits<double>::infinity();  ///< for duplicates
  std::vector<LandmarkMerge> merges_;
  std::size_t merges_taken_ = 0;
  std::unordered_set<int> changed_ids_;
  std::vector<int> removed_ids_;
  std::set<int> unconfirmed_ids_;
  std::unordered_set<int> told_pins_, pinned_ids_;  ///< as told; with merges followed
  /// By id: ids of close landmarks seen in the same scan, which are other objects.
  std::unordered_map<int, std::set<int>> distinct_from_;
  long scan_number_ = 0;
  int next_id_ = 0;
  Counts counts_;
};

}  // namespace hymm::core
