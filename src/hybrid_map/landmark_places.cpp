#include "hybrid_map/landmark_places.h"

namespace hymm::core {

void LandmarkPlaces::apply(const LandmarkMap& map) {
  places_.clear();
  for (const LandmarkEstimate& landmark : map.landmarks) places_[landmark.id] = landmark.position;
  for (const LandmarkMerge& merge : map.merges) merged_into_[merge.from_id] = merge.into_id;
}

void LandmarkPlaces::apply(const LandmarkUpdate& update) {
  for (const LandmarkMerge& merge : update.merges) merged_into_[merge.from_id] = merge.into_id;
  for (const LandmarkEstimate& landmark : update.changed) places_[landmark.id] = landmark.position;
  for (const int id : update.removed_ids) places_.erase(id);
}

int LandmarkPlaces::presentId(int id) const {
  // No chain of merges is longer than their number, unless it runs in a circle.
  for (std::size_t steps = 0; steps <= merged_into_.size(); ++steps) {
    if (places_.count(id) > 0) return id;
    const auto merged = merged_into_.find(id);
    if (merged == merged_into_.end()) break;
    id = merged->second;
  }
  return -1;
}

std::optional<Eigen::Vector2d> LandmarkPlaces::find(int id) const {
  return findUnmerged(presentId(id));
}

std::optional<Eigen::Vector2d> LandmarkPlaces::findUnmerged(int id) const {
  const auto place = places_.find(id);
  return place == places_.end() ? std::nullopt : std::optional<Eigen::Vector2d>(place->second);
}

std::pair<int, int> LandmarkPlaces::nearestTwo(const Eigen::Vector2d& place, double range_m,
                                               double separation_m) const {
  const int first = nearest(place, range_m, -1, 0.0);
  return {first, first < 0 ? -1 : nearest(place, range_m, first, separation_m)};
}

int LandmarkPlaces::nearest(const Eigen::Vector2d& place, double range_m, int apart_from,
                            double separation_m) const {
  const auto other = places_.find(apart_from);
  int best = -1;
  double best_distance = range_m;
  for (const auto& [id, position] : places_) {
    const double distance = (position - place).norm();
    // Of equals the lower id, whatever the order in the table.
    if (distance > best_distance || (distance == best_distance && best >= 0 && id > best)) continue;
    const bool is_apart = other == places_.end() ||
                          (id != apart_from && (position - other->second).norm() >= separation_m);
    if (!is_apart) continue;
    best = id;
    best_distance = distance;
  }
  return best;
}

}  // namespace hymm::core
