#include "pipeline/landmark_mirror.h"

#include <algorithm>

namespace hymm::core {
namespace {

// As many scans as a map may take to be made.
constexpr std::size_t kRecentChanges = 100;

auto placeOf(std::vector<LandmarkEstimate>& landmarks, int id) {
  return std::lower_bound(landmarks.begin(), landmarks.end(), id,
                          [](const auto& landmark, int key) { return landmark.id < key; });
}

/// Whoever sent them: by ascending id, each once. Of several under one id the first stays.
void order(std::vector<LandmarkEstimate>& landmarks) {
  const auto is_disordered = [](const auto& a, const auto& b) { return a.id >= b.id; };
  if (std::adjacent_find(landmarks.begin(), landmarks.end(), is_disordered) == landmarks.end())
    return;
  std::stable_sort(landmarks.begin(), landmarks.end(),
                   [](const auto& a, const auto& b) { return a.id < b.id; });
  const auto is_same = [](const auto& a, const auto& b) { return a.id == b.id; };
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end(), is_same), landmarks.end());
}

}  // namespace

void LandmarkMirror::take(const LandmarkMap& map) {
  const auto later = std::find_if(recent_.begin(), recent_.end(), [&](const auto& update) {
    return update.since_version >= map.version;
  });
  const bool continues = later != recent_.end() && later->since_version == map.version;
  if (map.version < map_.version && !continues) return;
  map_ = map;
  order(map_.landmarks);
  recent_.erase(recent_.begin(), continues ? later : recent_.end());
  for (const LandmarkUpdate& update : recent_) apply(update);
}

bool LandmarkMirror::take(const LandmarkUpdate& update) {
  if (update.version <= map_.version) return true;
  if (!recent_.empty() && recent_.back().version != update.since_version) recent_.clear();
  recent_.push_back(update);
  if (recent_.size() > kRecentChanges) recent_.pop_front();
  if (update.since_version > map_.version) return false;
  apply(update);
  return true;
}

void LandmarkMirror::apply(const LandmarkUpdate& update) {
  for (const int id : update.removed_ids) remove(id);
  for (const LandmarkEstimate& landmark : update.changed) change(landmark);
  map_.merges.insert(map_.merges.end(), update.merges.begin(), update.merges.end());
  map_.version = update.version;
}

void LandmarkMirror::change(const LandmarkEstimate& landmark) {
  const auto place = placeOf(map_.landmarks, landmark.id);
  if (place != map_.landmarks.end() && place->id == landmark.id) {
    *place = landmark;
  } else {
    map_.landmarks.insert(place, landmark);
  }
}

void LandmarkMirror::remove(int id) {
  const auto place = placeOf(map_.landmarks, id);
  if (place != map_.landmarks.end() && place->id == id) map_.landmarks.erase(place);
}

}  // namespace hymm::core
