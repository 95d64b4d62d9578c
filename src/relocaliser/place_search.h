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

namespace hymm::core {

/// What a search begins with.
struct SearchStart {
  double from_s = 0.0;             ///< stamp of the scan that `estimate` is of
  VehicleAmongLandmarks estimate;  ///< as the filter has it at that scan
  Calibration calibration;         ///< of the motion input, likewise
};

/// Runs the Relocaliser on what the sensors say. Keeps what they said lately, because a search
/// begins only after doubt has lasted, yet at the scan before that. Deterministic. Not
/// thread-safe.
class PlaceSearch {
 public:
  PlaceSearch(const RelocaliserConfig& config, const VehicleConfig& vehicle);

  /// Both in order of time. The outcome of a set while a search is on.
  void take(const MotionInput& input);
  std::optional<RelocaliserOutcome> take(const ObservationSet& set);

  /// Begins a search around the estimate, moved on by dead reckoning, in place of one that is on,
  /// with what was kept of the last `replay_s`. False, and no search is on, if that cannot be;
  /// `problem` says why.
  bool begin(const SearchStart& start, std::string& problem);
  /// The same anywhere among landmarks, from the last `replay_s` on. What it finds is a first
  /// guess: errors that the landmarks have in common are not taken for such.
  bool beginAnywhere(const std::vector<LandmarkEstimate>& landmarks, const Calibration& calibration,
                     std::string& problem);
  void end();
  /// The same, and forgets what was kept: another recording begins.
  void reset();

  bool isOn() const { return engine_.has_value(); }
  /// Of the last set; nothing before the first that was good enough to begin with.
  const std::optional<RelocaliserOutcome>& outcome() const { return outcome_; }
  /// The engine of the search that is on; null if none is.
  const Relocaliser* engine() const { return engine_ ? &*engine_ : nullptr; }
  /// Stamp from which the search that is on uses what was observed.
  double begun_s() const { return begun_s_; }

  /// The way that ends at the last outcome's pose: where the vehicle was, by dead reckoning back
  /// from there, at the scans later than `from_s`.
  std::vector<PlaceAtScan> wayFrom(double from_s) const;

 private:
  using Kept = std::variant<MotionInput, ObservationSet>;

  void keep(Kept kept);
  std::string findGap(double from_s) const;
  void start(LocalMap map, bool anywhere);

  RelocaliserConfig config_;
  VehicleConfig vehicle_;
  std::uint64_t searches_ = 0;
  std::deque<Kept> kept_;  ///< the last history_s, in order of time
  Calibration calibration_;
  double begun_s_ = 0.0;
  std::optional<Relocaliser> engine_;
  std::optional<RelocaliserOutcome> outcome_;
};

/// The estimate after the vehicle has moved by `motion`, to first order.
VehicleAmongLandmarks movedOn(VehicleAmongLandmarks estimate, const MotionSince& motion);

}  // namespace hymm::core
