#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "common/pose2.h"
#include "evaluation/trajectory.h"
#include "hybrid_map/property_sample.h"

namespace hymm::core {

/// A property as another sensor recorded it.
struct RecordedSample {
  PropertySample sample;              ///< its place and covariance are in its frame
  std::optional<Pose2> T_base_frame;  ///< nothing: its frame is map
};

/// Recorded samples on their way into map. Each waits for the first scan that is not earlier, and
/// is placed between the poses of the scans around its time, as tf does it live.
class RecordedSamples {
 public:
  void add(RecordedSample sample) { waiting_.push_back(std::move(sample)); }

  /// Those that a scan's pose, later than all before, allows to be placed. The rest waits on.
  std::vector<PropertySample> takePlaced(const StampedPose& T_map_base);

  /// The vehicle's poses up to now say nothing of what comes.
  void forgetPoses() { poses_.clear(); }
  /// Another recording begins.
  void reset();

  /// Samples of times at which there was no pose, among them those that still wait.
  std::size_t withoutPlace() const { return without_place_ + waiting_.size(); }

 private:
  std::deque<RecordedSample> waiting_;
  std::deque<StampedPose> poses_;  ///< of the last seconds, in order of time
  std::size_t without_place_ = 0;
};

}  // namespace hymm::core
