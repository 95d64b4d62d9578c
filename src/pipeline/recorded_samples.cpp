#include "pipeline/recorded_samples.h"

#include <utility>

namespace hymm::core {
namespace {

constexpr double kMemory_s = 10.0;  // as tf remembers

PropertySample placedBy(const Pose2& T_map_frame, PropertySample sample) {
  const Eigen::Matrix2d R = T_map_frame.rotation();
  sample.position = T_map_frame * sample.position;
  sample.covariance = R * sample.covariance * R.transpose();
  return sample;
}

}  // namespace

std::vector<PropertySample> RecordedSamples::takePlaced(const StampedPose& T_map_base) {
  poses_.push_back(T_map_base);
  while (poses_.front().time_s < T_map_base.time_s - kMemory_s) poses_.pop_front();
  std::vector<PropertySample> placed;
  std::deque<RecordedSample> later;
  for (RecordedSample& recorded : waiting_) {
    const double time_s = recorded.sample.sample.time_s;
    if (time_s > T_map_base.time_s) {
      later.push_back(std::move(recorded));
    } else if (!recorded.T_base_frame) {
      placed.push_back(std::move(recorded.sample));
    } else if (const auto pose = poseAt(poses_, time_s)) {
      placed.push_back(placedBy(*pose * *recorded.T_base_frame, std::move(recorded.sample)));
    } else {
      ++without_place_;
    }
  }
  waiting_ = std::move(later);
  return placed;
}

void RecordedSamples::reset() {
  without_place_ += waiting_.size();
  waiting_.clear();
  poses_.clear();
}

}  // namespace hymm::core
