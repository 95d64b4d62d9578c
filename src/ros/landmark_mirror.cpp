#include "ros/landmark_mirror.h"

#include <algorithm>

namespace hymm {
namespace {

auto placeOf(std::vector<core::LandmarkEstimate>& landmarks, int id) {
  return std::lower_bound(landmarks.begin(), landmarks.end(), id,
                          [](const auto& landmark, int key) { return landmark.id < key; });
}

}  // namespace

void LandmarkMirror::take(const core::LandmarkMap& map) {
  if (map.version >= map_.version) map_ = map;  // a change may overtake the map before it
}

bool LandmarkMirror::take(const core::LandmarkUpdate& update) {
  if (update.version <= map_.version) return true;
  if (update.since_version > map_.version) return false;
  for (const int id : update.removed_ids) remove(id);
  for (const core::LandmarkEstimate& landmark : update.changed) change(landmark);
  map_.merges.insert(map_.merges.end(), update.merges.begin(), update.merges.end());
  map_.version = update.version;
  return true;
}

void LandmarkMirror::change(const core::LandmarkEstimate& landmark) {
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

}  // namespace hymm
