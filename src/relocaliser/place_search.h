#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cekf/resumption.h"
#include "cekf/vehicle_among_landmarks.h"
#include "relocaliser/relocaliser.h"
#include "relocaliser/rival_inquiry.h"

namespace hymm::core {

/// What a search begins with.
struct SearchStart {
  double from_s = 0.0;             ///< stamp of the scan that `estimate` is of
  double now_s = 0.0;              ///< stamp of the scan at which the search was ordered
  VehicleAmongLandmarks estimate;  ///< as the filter has it at from_s
  Calibration calibration;         ///< of the motion input, likewise
};

/// Looks for the vehicle in what the sensors say, by one Relocaliser in each local map that it may
/// be in. Keeps what they said lately, because a search begins only after doubt has lasted, yet at
/// the scan before that. What is taken waits until work() does it, piece by piece; the outcome does
/// not depend on when that is. Deterministic. Not thread-safe.
class PlaceSearch {
 public:
  PlaceSearch(const RelocaliserConfig& config, const VehicleConfig& vehicle);

  /// Both in order of time.
  void take(const MotionInput& input);
  void take(const ObservationSet& set);

  /// Begins a search around the estimate, moved on by dead reckoning, in place of one that is on,
  /// with what was kept of the last `replay_s`. False, and no search is on, if that cannot be;
  /// `problem` says why.
  bool begin(const SearchStart& start, std::string& problem);
  /// The same anywhere in any of `maps`. What has not converged within restart_s begins anew.
  bool beginAnywhere(const std::vector<LocalMap>& maps, const Calibration& calibration,
                     double now_s, std::string& problem);
  void end();
  /// The same, and forgets what was kept: another recording begins.
  void reset();

  /// What came of a call of work().
  enum class Progress {
    kNothingWaits,
    kPieceDone,  ///< a part of a scan was done
    kScanDone    ///< a scan is done: outcome() and pose() are of it
  };
  /// Steps of a piece of the search for rivals: about a millisecond.
  static constexpr std::size_t kPieceSteps = 200000;

  /// One scan in one map, or a piece of the search for rivals of what was found.
  Progress work(std::size_t rival_steps = kPieceSteps);

  bool isOn() const { return !maps_.empty(); }
  /// Whether the next piece is one of the search for rivals.
  bool isSearchingRivals() const { return inquiry_.has_value(); }
  /// Why the search that was on had to be ended; empty if it did not.
  const std::string& failure() const { return failure_; }
  /// Stamp of the scan that was done last.
  double time_s() const { return time_s_; }
  /// Of that scan, by the map that explains all scans best; nothing if the scan told too little.
  const std::optional<RelocaliserOutcome>& outcome() const { return outcome_; }
  /// The heaviest mode, map frame, with the spread of all modes of all maps around it.
  const std::optional<PosePrior>& pose() const { return pose_; }
  /// Of the map that explains all scans best; null if no search is on.
  const Relocaliser* engine() const { return isOn() ? &maps_[best_].engine : nullptr; }
  /// Stamp from which the search that is on uses what was observed.
  double begun_s() const { return begun_s_; }
  /// Maps that are still looked in.
  std::size_t mapsLeft() const;

  /// The way that ends at the last outcome's pose: where the vehicle was, by dead reckoning back
  /// from there, at the scans later than `from_s`.
  std::vector<PlaceAtScan> wayFrom(double from_s) const;

 private:
  using Kept = std::variant<MotionInput, ObservationSet>;

  struct SearchedMap {
    Relocaliser engine;
    std::optional<RelocaliserOutcome> outcome;  ///< of the scan that is being done
    double log_likelihood = 0.0;  ///< of the last scans at its heaviest mode; -inf without one
    bool is_left = false;         ///< others explain what is seen far better, or know its place
  };

  void keep(Kept kept);
  std::string findGap(double from_s) const;
  void addEngine();
  void beginAt(double now_s, double earliest_s);
  const ObservationSet* nextSet();
  void skipLeft();
  bool isLookedIn(SearchedMap& map, const ObservationSet& set, std::size_t rival_steps);
  void weighMaps(double time_s);
  std::optional<bool> findRivalMap(std::size_t rival_steps);
  std::vector<const LocalMap*> otherMaps() const;
  void finishScan(double time_s, bool has_rival_map);
  void tellBest(bool has_rival_map);
  PosePrior spreadOfAll() const;
  bool isSamePlace(const SearchedMap& map) const;
  bool isElsewhere(const Pose2& apart) const;
  bool hasRivalMode() const;
  void restartIfDue();

  RelocaliserConfig config_;
  VehicleConfig vehicle_;
  std::uint64_t engines_ = 0;  ///< made so far
  std::deque<Kept> kept_;      ///< the last history_s, in order of time
  std::size_t first_kept_ = 0;
  Calibration calibration_;
  double begun_s_ = 0.0;
  double restarted_s_ = 0.0;
  bool anywhere_ = false;
  std::vector<SearchedMap> maps_;
  std::vector<double> shares_;  ///< of the weight, by map
  std::size_t next_ = 0;        ///< of what was kept, counted from the start: to be done next
  std::size_t turn_ = 0;        ///< the map that does it next; beyond the last: they are judged
  std::size_t best_ = 0;
  std::optional<RivalInquiry> inquiry_;    ///< about the map whose turn it is, or about the best
  std::optional<std::size_t> unrivalled_;  ///< the map whose outcome no other has a rival of
  int scans_ = 0;                          ///< that told something since the maps began
  double told_from_s_ = 0.0;               ///< stamp of the first of them
  double time_s_ = 0.0;
  std::string failure_;
  std::optional<RelocaliserOutcome> outcome_;
  std::optional<PosePrior> pose_;
};

/// The estimate after the vehicle has moved by `motion`, to first order.
VehicleAmongLandmarks movedOn(VehicleAmongLandmarks estimate, const MotionSince& motion);

}  // namespace hymm::core
