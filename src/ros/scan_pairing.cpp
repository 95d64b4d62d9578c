#include "ros/scan_pairing.h"

#include <algorithm>
#include <utility>

#include "ros/filter_conversions.h"

namespace hymm {
namespace {

constexpr std::size_t kMostWaiting = 5000;  // of each topic; a minute of a fast playback
constexpr std::size_t kMostMaps = 20;       // large, and at most one a second of the recording
constexpr double kPatience_s = 2.0;         // for what travels beside the pose
constexpr double kMapPatience_s = 10.0;     // a whole map takes its time to be made

template <class Queue>
bool makeRoom(Queue& queue, std::size_t most) {
  if (queue.size() < most) return false;
  queue.pop_front();
  return true;
}

}  // namespace

void ScanPairing::add(const HeadedScan::ConstPtr& scan) {
  // The filter takes one scan of a stamp from each sensor.
  if (scan->header.stamp != newest_stamp_) newest_frames_.clear();
  newest_stamp_ = scan->header.stamp;
  if (!newest_frames_.insert(scan->header.frame_id).second) {
    ++counts_.unused_scans;
    return;
  }
  if (makeRoom(scans_, kMostWaiting)) {
    ++counts_.overflows;
    ++counts_.dropped_scans;
  }
  scans_.push_back(scan);
}

void ScanPairing::add(const FilterPose::ConstPtr& pose, double now_s) {
  if (makeRoom(poses_, kMostWaiting)) ++counts_.overflows;
  const core::FilterCourse course = filter_.take(countersOf(*pose));
  if (course == core::FilterCourse::kNewFilter) {
    // They wait for what nobody will send any more, and their map is gone.
    counts_.missing_poses += poses_.size();
    poses_.clear();
  }
  poses_.push_back({pose, now_s, course != core::FilterCourse::kGoesOn});
}

void ScanPairing::add(const LandmarkUpdate::ConstPtr& update) {
  if (makeRoom(updates_, kMostWaiting)) ++counts_.overflows;
  updates_.push_back(update);
}

void ScanPairing::add(const LandmarkMap::ConstPtr& map) {
  makeRoom(maps_, kMostMaps);  // most are not announced, or used already
  maps_.push_back(map);
}

std::optional<PairedScan> ScanPairing::next(double now_s, bool has_scans) {
  while (!poses_.empty()) {
    const FilterPose& pose = *poses_.front().pose;
    const double waited_s = now_s - poses_.front().at_s;
    if (poses_.front().begins_anew) forgetScansBeforeJump();
    const Search update = findUpdate(waited_s > kPatience_s);
    if (update == Search::kWaiting) return std::nullopt;
    if (update == Search::kNone) {
      ++counts_.missing_poses;
      poses_.pop_front();
      continue;
    }
    if (updates_.front()->version != pose.map_version) return takeLoneUpdate();

    PairedScan paired{updates_.front(), poses_.front().pose, nullptr, nullptr};
    Search map = Search::kNone;
    if (paired.update->map_follows) {
      map = findMap(*paired.update, waited_s > kMapPatience_s, paired.map);
    }
    const bool is_late = !has_scans || waited_s > kPatience_s;
    const Search scan = findScan(pose.header.stamp, is_late, paired.scan);
    // Nothing is taken before all is there: what came first would be lost.
    if (map == Search::kWaiting || scan == Search::kWaiting) return std::nullopt;
    if (map == Search::kNone && paired.update->map_follows) ++counts_.missing_maps;
    if (scan == Search::kNone && has_scans) ++counts_.missing_scans;
    takeMap(paired.map);
    takeScan(paired.scan);
    updates_.pop_front();
    poses_.pop_front();
    return paired;
  }
  return std::nullopt;
}

/// With all that came before it.
void ScanPairing::takeMap(const LandmarkMap::ConstPtr& map) {
  const auto found = std::find(maps_.begin(), maps_.end(), map);
  if (found != maps_.end()) maps_.erase(maps_.begin(), found + 1);
}

/// With all that came before it, which nobody had a use for.
void ScanPairing::takeScan(const HeadedScan::ConstPtr& scan) {
  const auto found = std::find(scans_.begin(), scans_.end(), scan);
  if (found == scans_.end()) return;
  counts_.unused_scans += static_cast<std::size_t>(found - scans_.begin());
  scans_.erase(scans_.begin(), found + 1);
}

/// An update whose pose got lost: whoever follows the landmarks needs it all the same.
std::optional<PairedScan> ScanPairing::takeLoneUpdate() {
  ++counts_.missing_poses;
  PairedScan alone{updates_.front(), nullptr, nullptr, nullptr};
  findMap(*alone.update, true, alone.map);
  takeMap(alone.map);
  updates_.pop_front();
  return alone;
}

/// Whether the update of the first pose is here; others may be before it.
ScanPairing::Search ScanPairing::findUpdate(bool is_late) {
  const FilterPose& pose = *poses_.front().pose;
  const auto found = std::find_if(updates_.begin(), updates_.end(), [&](const auto& update) {
    return update->version == pose.map_version && update->header.stamp == pose.header.stamp;
  });
  if (found != updates_.end()) return Search::kFound;
  // Of a filter that was started anew since, versions or stamps are lower.
  const bool was_passed = !updates_.empty() && updates_.front()->version > pose.map_version &&
                          updates_.front()->header.stamp > pose.header.stamp;
  return is_late || was_passed ? Search::kNone : Search::kWaiting;
}

/// The map that an update announced. One that was sent before this node subscribed never comes; a
/// later one tells so.
ScanPairing::Search ScanPairing::findMap(const LandmarkUpdate& update, bool is_late,
                                         LandmarkMap::ConstPtr& map) const {
  const auto found = std::find_if(maps_.begin(), maps_.end(), [&](const auto& held) {
    return held->version == update.version;
  });
  if (found == maps_.end()) {
    const bool was_passed = std::any_of(maps_.begin(), maps_.end(), [&](const auto& held) {
      return held->version > update.version && held->header.stamp > update.header.stamp;
    });
    return is_late || was_passed ? Search::kNone : Search::kWaiting;
  }
  map = *found;
  return Search::kFound;
}

ScanPairing::Search ScanPairing::findScan(const ros::Time& stamp, bool is_late,
                                          HeadedScan::ConstPtr& scan) const {
  // A filter that does not use the times of beams takes a scan as of the stamp that was told.
  const auto found = std::find_if(scans_.begin(), scans_.end(), [&](const auto& held) {
    return held->header.stamp == stamp || held->told_stamp == stamp;
  });
  if (found != scans_.end()) {
    scan = *found;
    return Search::kFound;
  }
  const bool was_passed = std::any_of(scans_.begin(), scans_.end(),
                                      [&](const auto& held) { return held->header.stamp > stamp; });
  return is_late || was_passed ? Search::kNone : Search::kWaiting;
}

/// The filter began anew: if stamps ran back, what is left of the old recording is of no use.
void ScanPairing::forgetScansBeforeJump() {
  const auto jump = std::adjacent_find(scans_.rbegin(), scans_.rend(),
                                       [](const auto& later, const auto& earlier) {
                                         return later->header.stamp < earlier->header.stamp;
                                       });
  if (jump == scans_.rend()) return;
  const auto first_new = jump.base() - 1;
  counts_.unused_scans += static_cast<std::size_t>(first_new - scans_.begin());
  scans_.erase(scans_.begin(), first_new);
}

void ScanPairing::clear() {
  scans_.clear();
  newest_frames_.clear();
  poses_.clear();
  updates_.clear();
  maps_.clear();
}

}  // namespace hymm
