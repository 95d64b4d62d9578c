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

/// Notes a message of the source, and forgets all if it is the first word of another filter.
void LandmarkMirror::listen(Source& source, std::uint64_t version) {
  if (source.life.take({version}) != FilterCourse::kNewFilter) return;
  if (source.restarts == restarts_) {  // else another source told it before
    ++restarts_;
    map_ = LandmarkMap();
    recent_.clear();
  }
  source.restarts = restarts_;
}

/// Whether the changes that came tell of this version.
bool LandmarkMirror::isTold(std::uint64_t version) const {
  return std::any_of(recent_.begin(), recent_.end(), [&](const LandmarkUpdate& update) {
    return update.since_version == version || update.version == version;
  });
}

void LandmarkMirror::take(const LandmarkMap& map) {
  listen(maps_, map.version);
  // It may be of the filter before, unless the changes of the present one lead to it.
  if (maps_.restarts != restarts_ && !isTold(map.version)) return;
  maps_.restarts = restarts_;
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
  listen(updates_, update.version);
  if (update.version <= map_.version) return true;
  if (!recent_.empty() && recent_.back().version != update.since_version) recent_.clear();
  recent_.push_back(update);
  if (recent_.size() > kRecentChanges) recent_.pop_front();
  if (update.since_version > map_.version) return false;
  updates_.restarts = restarts_;
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
