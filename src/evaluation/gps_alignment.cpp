#include "evaluation/gps_alignment.h"

#include <cmath>

namespace hymm::core {
namespace {

// A rigid motion has three parameters: two fixes determine it and say nothing about errors.
constexpr std::size_t kFewestFixes = 3;

}  // namespace

void GpsAlignment::addPose(const StampedPose& T_map_base) {
  while (!waiting_.empty() && waiting_.front().time_s <= T_map_base.time_s) {
    const GpsFix& fix = waiting_.front();
    const bool at_pose = fix.time_s == T_map_base.time_s;
    const bool between = last_pose_ && fix.time_s >= last_pose_->time_s &&
                         T_map_base.time_s - last_pose_->time_s <= kLongestInterpolation_s;
    if (at_pose || between) {
      const Pose2 pose =
          at_pose ? T_map_base.pose : interpolate(*last_pose_, T_map_base, fix.time_s);
      alignment_.add(pose * fix.antenna, fix.position);
    }
    waiting_.pop_front();
  }
  last_pose_ = T_map_base;
}

void GpsAlignment::addFix(const GpsFix& fix) {
  if (!gate_.keep(fix.time_s, fix.position)) return;
  if (last_pose_ && fix.time_s == last_pose_->time_s) {
    alignment_.add(last_pose_->pose * fix.antenna, fix.position);
  } else {
    waiting_.push_back(fix);
  }
}

void GpsAlignment::startMap() {
  finished_maps_ = withCurrentMap();
  last_pose_.reset();
  waiting_.clear();
  gate_ = {};
  alignment_ = {};
}

GpsAlignment::Sum GpsAlignment::withCurrentMap() const {
  Sum sum = finished_maps_;
  if (alignment_.count() >= kFewestFixes) {
    sum.squared_error_m2 += alignment_.squaredError();
    sum.count += alignment_.count();
  }
  return sum;
}

std::size_t GpsAlignment::count() const { return withCurrentMap().count; }

std::optional<double> GpsAlignment::rmse() const {
  const Sum sum = withCurrentMap();
  if (sum.count == 0) return std::nullopt;
  return std::sqrt(sum.squared_error_m2 / static_cast<double>(sum.count));
}

}  // namespace hymm::core
