#include "ros/level_set_record.h"

#include <cmath>

#include "common/unfinished_file.h"
#include "pipeline/information_stage.h"
#include "ros/information_conversions.h"

namespace hymm {

void LevelSetRecord::subscribe(ros::NodeHandle& handle) {
  subscriber_ = handle.subscribe("level_sets", 32, &LevelSetRecord::takeSet, this,
                                 ros::TransportHints().tcpNoDelay());
}

void LevelSetRecord::takeSet(const LevelSet& message) {
  if (!std::isfinite(message.value)) return;
  if (sets_.size() < kMostSets || sets_.count(message.value) > 0) sets_[message.value] = message;
}

void LevelSetRecord::write() const {
  if (sets_.empty()) return;
  core::LevelSets sets;
  for (const auto& [value, message] : sets_) sets.sets.push_back(fromMessage(message));
  core::replaceFile(folder_ / "level_sets.csv", core::levelSetsText(sets));
}

}  // namespace hymm
