#include "rviz_displays/landmark_feed.h"

#include <algorithm>
#include <utility>

#include "ros/map_conversions.h"
#include "scene/landmark_shapes.h"

namespace hymm {
namespace {

constexpr std::uint32_t kMaps = 2, kUpdates = 1000;

}  // namespace

void LandmarkFeed::subscribe(ros::NodeHandle& handle, const std::string& map_topic,
                             const std::string& update_topic) {
  stop();
  map_topic_ = map_topic;
  if (!map_topic.empty()) {
    map_subscriber_ = handle.subscribe(map_topic, kMaps, &LandmarkFeed::takeMap, this);
  }
  if (!update_topic.empty()) {
    update_subscriber_ = handle.subscribe(update_topic, kUpdates, &LandmarkFeed::takeUpdate, this);
  }
}

void LandmarkFeed::stop() {
  map_subscriber_.shutdown();
  update_subscriber_.shutdown();
  clear();
}

void LandmarkFeed::clear() {
  mirror_ = core::LandmarkMirror();
  frame_.clear();
  last_stamp_ = ros::Time();
  gap_ = false;
  refused_ = 0;
  refusal_.clear();
  news_ = true;
}

bool LandmarkFeed::takeNews() { return std::exchange(news_, false); }

LandmarkFeed::State LandmarkFeed::state() const {
  if (refused_ > 0) {
    return {false, std::to_string(refused_) + " messages refused, the last because " + refusal_};
  }
  if (!hasMap()) {
    return {false, "No landmark map has come on '" + map_topic_ + "'. Is cekf_slam running?"};
  }
  const std::string sentence = std::to_string(map().landmarks.size()) + " landmarks, version " +
                               std::to_string(map().version);
  if (gap_) return {false, sentence + "; updates were lost, the next whole map mends it"};
  return {true, sentence};
}

bool LandmarkFeed::isUsable(const std::vector<core::LandmarkEstimate>& landmarks,
                            const char* what) {
  const auto problem = core::problemWith(landmarks);
  if (!problem) return true;
  ++refused_;
  refusal_ = std::string("in ") + what + " " + *problem;
  news_ = true;
  return false;
}

void LandmarkFeed::takeMap(const LandmarkMap& message) {
  const core::LandmarkMap map = fromMessage(message);
  if (!isUsable(map.landmarks, "a map")) return;
  // A lower version is late, unless its stamp is the latest: then the filter began anew.
  if (map.version < mirror_.map().version && message.header.stamp > last_stamp_) {
    mirror_ = core::LandmarkMirror();
  }
  last_stamp_ = std::max(last_stamp_, message.header.stamp);
  mirror_.take(map);
  frame_ = message.header.frame_id.empty() ? "map" : message.header.frame_id;
  gap_ = false;
  news_ = true;
}

void LandmarkFeed::takeUpdate(const LandmarkUpdate& message) {
  const core::LandmarkUpdate update = fromMessage(message);
  if (!isUsable(update.changed, "an update")) return;
  last_stamp_ = std::max(last_stamp_, message.header.stamp);
  gap_ = !mirror_.take(update) && hasMap();
  news_ = true;
}

}  // namespace hymm
