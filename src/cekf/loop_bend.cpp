#include "cekf/loop_bend.h"

#include <algorithm>
#include <cmath>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

// Landmarks that came before and after one, of which it is told how far that turns.
constexpr std::size_t kNeighbours = 3;

}  // namespace

double turnOf(const std::vector<Move>& moves) {
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const Move& move : moves) {
    from += move.from / static_cast<double>(moves.size());
    to += move.to / static_cast<double>(moves.size());
  }
  double dot = 0.0, cross = 0.0;
  for (const Move& move : moves) {
    const Vector2d before = move.from - from, after = move.to - to;
    dot += before.dot(after);
    cross += before.x() * after.y() - before.y() * after.x();
  }
  return moves.size() < 2 ? 0.0 : std::atan2(cross, dot);
}

LoopBend::LoopBend(const LandmarkRegistry& registry, const CompressedEkf& filter)
    : pose_(filter.vehicle().head<3>()) {
  std::vector<RegisteredLandmark> all = registry.all();
  std::stable_sort(all.begin(), all.end(), [](const auto& one, const auto& other) {
    return one.first_seen_s < other.first_seen_s;
  });
  for (const RegisteredLandmark& landmark : all) {
    before_.push_back({landmark.slot, filter.landmark(landmark.slot)});
  }
}

void LoopBend::follow(VehicleState& vehicle, LandmarkRegistry& registry,
                      CompressedEkf& filter) const {
  if (filter.areLandmarksFixed()) return;
  std::vector<int> slots;
  std::vector<Move> moves;
  for (const Place& before : before_) {
    if (registry.bySlot(before.slot).id < 0) continue;  // it was fused with another
    slots.push_back(before.slot);
    moves.push_back({before.position, filter.landmark(before.slot)});
  }
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const std::size_t first = k - std::min(k, kNeighbours);
    const std::size_t last = std::min(k + kNeighbours + 1, moves.size());
    RegisteredLandmark& landmark = registry.bySlot(slots[k]);
    landmark.linearised_at += moves[k].to - moves[k].from;
    landmark.turn_rad += turnOf({moves.begin() + static_cast<std::ptrdiff_t>(first),
                                 moves.begin() + static_cast<std::ptrdiff_t>(last)});
    if (filter.isActive(slots[k])) takeTurn(landmark, filter);
  }
  const Eigen::Vector3d moved = filter.vehicle().head<3>() - pose_;
  vehicle.linearisePositionAt(vehicle.linearisedAt() + moved.head<2>());
  filter.turnVehicleError(wrapAngle(moved.z()));
}

void takeTurn(RegisteredLandmark& landmark, CompressedEkf& filter) {
  if (landmark.turn_rad == 0.0 || filter.areLandmarksFixed()) return;
  filter.activate(landmark.slot);
  filter.turnError(landmark.slot, landmark.turn_rad);
  landmark.turn_rad = 0.0;
}

}  // namespace hymm::core
