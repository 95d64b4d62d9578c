#pragma once

#include <optional>
#include <vector>

#include "common/random.h"
#include "relocaliser/relocaliser.h"

namespace hymm::core {

/// Looks for a vehicle that may be anywhere in a large map: one Relocaliser in each of several
/// local maps. A place is accepted when one of them has converged, and no other has elsewhere.
class GlobalSearch {
 public:
  /// `restart_s`: what has not converged by then begins anew, since the vehicle may have driven
  /// from one map into another, or seen too little at first. Throws std::invalid_argument without a
  /// map.
  GlobalSearch(const RelocaliserConfig& config, const VehicleConfig& vehicle,
               const Calibration& calibration, std::vector<LocalMap> maps, double restart_s,
               RandomGenerator generator);

  void begin(double time_s);
  void process(const MotionInput& input);
  /// The outcome of the one that has converged; nothing as long as none has, or several in places
  /// that differ.
  std::optional<RelocaliserOutcome> process(const ObservationSet& set);

  std::size_t maps() const { return maps_.size(); }
  /// Scans at which several places were converged to.
  std::size_t contradictions() const { return contradictions_; }

 private:
  std::vector<LocalMap> maps_;
  std::vector<Relocaliser> searches_;
  double restart_s_;
  double begun_s_ = 0.0;
  double same_place_m_;
  std::size_t contradictions_ = 0;
};

}  // namespace hymm::core
