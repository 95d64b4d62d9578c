#include "cekf/loop_bend.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cekf/error_transport.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// A step that turns by this stretches by 0.0002.
constexpr double kStep_rad = 0.02;

// Between where the covariance belongs and where the update ends.
constexpr double kTolerance_m = 0.01;

constexpr int kMostSteps = 200;

/// Landmarks that the update moves by more than `least_m`; of too many, those that move most.
std::vector<int> landmarksMoved(const std::vector<SparseMeasurement>& measurements, double least_m,
                                const LandmarkRegistry& registry, const CompressedEkf& filter) {
  std::vector<int> slots;
  for (const RegisteredLandmark& landmark : registry.all()) slots.push_back(landmark.slot);
  const std::vector<Vector2d> moves = filter.movesBy(measurements, slots);
  std::vector<std::pair<double, int>> moved;
  for (std::size_t k = 0; k < moves.size(); ++k) {
    if (moves[k].norm() > least_m) moved.emplace_back(-moves[k].norm(), slots[k]);
  }
  std::sort(moved.begin(), moved.end());
  if (moved.size() > kMostBent) moved.resize(kMostBent);
  slots.clear();
  for (const auto& [move, slot] : moved) slots.push_back(slot);
  return slots;
}

/// The way from the estimates as they were to where the update leads from there.
class Way {
 public:
  Way(const MeasurementsNow& measurements, const std::vector<int>& slots, CompressedEkf& filter)
      : measurements_(measurements),
        filter_(filter),
        transport_(placesOf(slots, filter), filter.activeCovariance()),
        gone_(VectorXd::Zero(filter.activeStates().size())),
        moved_(gone_) {}

  /// False if there is no end.
  bool goToEnd() {
    for (int step = 0; step < kMostSteps; ++step) {
      const std::optional<VectorXd> left = leftToGo();
      if (!left) return false;
      if (filter_.largestMove(filter_.activeStates() + *left) < kTolerance_m) return true;
      go(*left);
    }
    return false;
  }

  /// Puts the estimates back to where they were, seen in the axes as they are now.
  void putBack() { filter_.moveStates(-gone_); }

  /// What the states were moved by, on the way.
  const VectorXd& moved() const { return moved_; }

 private:
  static std::vector<int> placesOf(const std::vector<int>& slots, const CompressedEkf& filter) {
    std::vector<int> places{0};
    for (const int slot : slots) places.push_back(filter.activeRow(slot));
    return places;
  }

  /// From here to where the update leads from the estimates as they were: with the gain K of the
  /// present covariance, K (z - h(x) + H * gone) - gone.
  std::optional<VectorXd> leftToGo() const {
    std::vector<SparseMeasurement> measurements = measurements_();
    for (SparseMeasurement& measurement : measurements) {
      if (measurement.H_vehicle.cols() > 0) {
        measurement.innovation += measurement.H_vehicle * gone_.head(filter_.vehicleStates());
      }
      for (int k = 0; k < SparseMeasurement::kPairs; ++k) {
        const int slot = measurement.landmarks[k];
        if (slot == SparseMeasurement::kNone) continue;
        measurement.innovation +=
            measurement.H_landmarks[k] * gone_.segment<2>(filter_.activeRow(slot));
      }
    }
    std::optional<VectorXd> states = filter_.statesAfter(measurements);
    if (states) *states -= filter_.activeStates() + gone_;
    return states;
  }

  void go(const VectorXd& left) {
    const VectorXd states = filter_.activeStates();
    const double turn_rad = transport_.turns(states, left).cwiseAbs().maxCoeff();
    const VectorXd moves = turn_rad > kStep_rad ? VectorXd(kStep_rad / turn_rad * left) : left;
    const ErrorTransport::Map map = transport_.mapAlong(states, moves);
    filter_.redefineErrors([&map](const MatrixXd& errors) { return map * errors; });
    filter_.moveStates(moves);
    gone_ = map * MatrixXd(gone_ + moves);
    moved_ += moves;
  }

  const MeasurementsNow& measurements_;
  CompressedEkf& filter_;
  ErrorTransport transport_;
  VectorXd gone_;  ///< from the estimates as they were, in the axes as they are now
  VectorXd moved_;
};

}  // namespace

bool bendMap(const MeasurementsNow& measurements, double least_move_m, VehicleState& vehicle,
             LandmarkRegistry& registry, CompressedEkf& filter) {
  if (filter.areLandmarksFixed()) return false;
  const std::optional<VectorXd> straight = filter.statesAfter(measurements());
  if (!straight || filter.largestMove(*straight) <= least_move_m) return false;

  const std::vector<int> slots =
      landmarksMoved(measurements(), 0.1 * least_move_m, registry, filter);
  for (const int slot : slots) filter.activate(slot);
  const LocalState before = filter.localState();
  Way way(measurements, slots, filter);
  if (!way.goToEnd()) {
    filter.goBackTo(before);
    return false;
  }
  way.putBack();
  vehicle.linearisePositionAt(vehicle.linearisedAt() + way.moved().head<2>());
  for (const int slot : slots) {
    registry.bySlot(slot).linearised_at += way.moved().segment<2>(filter.activeRow(slot));
  }
  return true;
}

}  // namespace hymm::core
