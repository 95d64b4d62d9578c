#include "ros/sample_placer.h"

#include <utility>

#include "ros/grid_conversions.h"
#include "ros/pose_conversions.h"
#include "ros/transform_lookup.h"

namespace hymm {
namespace {

constexpr std::size_t kMostWaiting = 10000;

}  // namespace

SamplePlacer::SamplePlacer(const tf2::BufferCore& tf, const std::string& map_frame, double wait_s,
                           CauseLog& causes)
    : tf_(tf), map_frame_(withoutSlash(map_frame)), wait_s_(wait_s), causes_(causes) {}

void SamplePlacer::add(const PropertySample::ConstPtr& sample, double steady_now_s) {
  if (waiting_.size() >= kMostWaiting) {
    causes_.count("samples dropped", "More property samples wait for tf than there is room for.");
    waiting_.pop_front();
  }
  waiting_.push_back({sample, steady_now_s});
}

std::vector<core::PropertySample> SamplePlacer::takePlaced(double steady_now_s) {
  std::vector<core::PropertySample> placed;
  std::deque<Waiting> still_waiting;
  for (const Waiting& waiting : waiting_) {
    const std_msgs::Header& header = waiting.sample->header;
    const std::string frame = withoutSlash(header.frame_id);
    if (frame == map_frame_) {
      placed.push_back(fromMessage(*waiting.sample, core::Pose2()));
      continue;
    }
    const TransformAnswer found = findTransform(tf_, map_frame_, frame, header.stamp);
    if (found.transform) {
      placed.push_back(fromMessage(*waiting.sample, fromMessage(found.transform->transform)));
    } else if (steady_now_s - waiting.since_s < wait_s_) {
      still_waiting.push_back(waiting);
    } else {
      causes_.count(
          "samples of frame '" + header.frame_id + "' without a place",
          "Property samples of frame '" + header.frame_id + "' are refused: " + found.problem);
    }
  }
  waiting_ = std::move(still_waiting);
  return placed;
}

}  // namespace hymm
