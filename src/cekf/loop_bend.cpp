#include "cekf/loop_bend.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cekf/error_transport.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

// A step that turns by this stretches by 0.0002.
constexpr double kStep_rad = 0.02;

// What is left for the update.
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

/// The way to where the update leads.
class Way {
 public:
  Way(const MeasurementsNow& measurements, const std::vector<int>& slots, CompressedEkf& filter)
      : measurements_(measurements),
        filter_(filter),
        transport_(placesOf(slots, filter), filter.activeCovariance()),
        moved_(VectorXd::Zero(filter.activeStates().size())) {}

  /// False if there is no end.
  bool goToEnd() {
    for (int step = 0; step < kMostSteps; ++step) {
      const std::optional<VectorXd> end = filter_.statesAfter(measurements_());
      if (!end) return false;
      if (filter_.largestMove(*end) < kTolerance_m) return true;
      goTowards(*end);
    }
    return false;
  }

  /// What the states were moved by, on the way.
  const VectorXd& moved() const { return moved_; }

 private:
  static std::vector<int> placesOf(const std::vector<int>& slots, const CompressedEkf& filter) {
    std::vector<int> places{0};
    for (const int slot : slots) places.push_back(filter.activeRow(slot));
    return places;
  }

  void goTowards(const VectorXd& end) {
    const VectorXd states = filter_.activeStates(), left = end - states;
    const double turn_rad = transport_.turns(states, left).cwiseAbs().maxCoeff();
    const VectorXd moves = turn_rad > kStep_rad ? VectorXd(kStep_rad / turn_rad * left) : left;
    const ErrorTransport::Map map = transport_.mapAlong(states, moves);
    filter_.redefineErrors([&map](const Eigen::MatrixXd& errors) { return map * errors; });
    filter_.moveStates(moves);
    moved_ += moves;
  }

  const MeasurementsNow& measurements_;
  CompressedEkf& filter_;
  ErrorTransport transport_;
  VectorXd moved_;
};

}  // namespace

double bendMap(const MeasurementsNow& measurements, double least_move_m, VehicleState& vehicle,
               LandmarkRegistry& registry, CompressedEkf& filter) {
  if (filter.areLandmarksFixed()) return 0.0;
  const std::optional<VectorXd> straight = filter.statesAfter(measurements());
  if (!straight || filter.largestMove(*straight) <= least_move_m) return 0.0;

  const std::vector<int> slots =
      landmarksMoved(measurements(), 0.1 * least_move_m, registry, filter);
  for (const int slot : slots) filter.activate(slot);
  const LocalState before = filter.localState();
  Way way(measurements, slots, filter);
  if (!way.goToEnd()) {
    filter.goBackTo(before);
    return 0.0;
  }
  vehicle.linearisePositionAt(vehicle.linearisedAt() + way.moved().head<2>());
  double farthest_m = 0.0;
  for (const int slot : slots) {
    const Vector2d moved = way.moved().segment<2>(filter.activeRow(slot));
    registry.bySlot(slot).linearised_at += moved;
    farthest_m = std::max(farthest_m, moved.norm());
  }
  return farthest_m;
}

}  // namespace hymm::core
