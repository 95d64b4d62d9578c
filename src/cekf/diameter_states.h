#pragma once

#include <unordered_map>

#include "cekf/compressed_ekf.h"
#include "perception/observation.h"

namespace hymm::core {

/// A diameter among the filter's states: one half of a slot, or none.
struct DiameterState {
  int slot = SparseMeasurement::kNone;
  int half = 0;

  bool exists() const { return slot != SparseMeasurement::kNone; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(slot, half);
  }
};

/// What is known of a trunk's diameter before it is seen [m].
struct DiameterPrior {
  double mean_m = 0.55;
  double deviation_m = 0.26;
};

/// Whether the place that an observation gives its object hangs on the object's diameter.
bool dependsOnDiameter(const Observation& observation);

/// The observation as it is if the object's diameter is `diameter_m`: range and bearing with their
/// covariance under that condition. By the diameter they change at the rate `diameterGain()`.
Observation conditionedOnDiameter(Observation observation, double diameter_m);
Eigen::Vector2d diameterGain(const Observation& observation);

/// Diameters of trunks as states of the filter, two to a slot. A laser meets a trunk's surface; its
/// centre is half the diameter behind. What it tells of the diameter from afar is wrong in the same
/// way from scan to scan, hence so is the range to the centre; as a state, that error is one.
class DiameterStates {
 public:
  explicit DiameterStates(const DiameterPrior& prior) : prior_(prior) {}

  /// A new diameter, of which `first` is the first sighting. Active.
  DiameterState add(const Observation& first, CompressedEkf& filter);
  void remove(const DiameterState& state, CompressedEkf& filter);
  void clear();

  static double mean(const DiameterState& state, const CompressedEkf& filter);
  static double variance(const DiameterState& state, const CompressedEkf& filter);

  /// Takes from a sighting what it tells of the diameter itself, if that is worth having.
  static void observe(const Observation& sighting, const DiameterState& state,
                      CompressedEkf& filter);

  template <class Archive>
  void describeState(Archive& archive) {
    archive(open_, used_);
  }

 private:
  static void update(const Observation& sighting, const DiameterState& state,
                     CompressedEkf& filter);

  DiameterPrior prior_;
  DiameterState open_;                 ///< given out next, if it exists
  std::unordered_map<int, int> used_;  ///< by slot: halves that stand for a trunk
};

}  // namespace hymm::core
