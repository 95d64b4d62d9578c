#include "supervisor/old_landmarks.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

// Landmarks that were in a part of the view, summed over scans, by which it is judged.
constexpr int kEnoughLooks = 15;

}  // namespace

void OldLandmarkConfig::describe(ConfigSchema& schema) {
  schema.number("age_s", age_s, Range::notNegative(),
                "a landmark is old when it was put into the map longer ago");
  schema.integer("least_observations", least_observations, Range::between(1, 100000),
                 "... and was observed so often");
  schema.number("unseen_s", unseen_s, Range::positive(),
                "it has not been seen lately when it was last seen longer ago");
  schema.number("range_m", range_m, Range::positive(),
                "it should be in view within this range of the sensor ...");
  schema.number("half_angle_rad", half_angle_rad, Range{0.0, 3.1416, true},
                "... and this angle from the sensor's x axis ...");
  schema.number("seen_share", seen_share, Range::between(0.0, 1.0),
                "... in a part of that view in which this share of the old ones was seen so far");
}

OldLandmarksInView OldLandmarkWatch::look(const std::vector<LandmarkEstimate>& landmarks,
                                          const Pose2& T_map_sensor, double time_s) {
  const Pose2 T_sensor_map = inverse(T_map_sensor);
  OldLandmarksInView result;
  for (const LandmarkEstimate& landmark : landmarks) {
    if (landmark.first_seen_s > time_s - config_.age_s ||
        landmark.observations < config_.least_observations) {
      continue;
    }
    const std::optional<std::size_t> number = partOf(T_sensor_map * landmark.position);
    if (!number) continue;
    Part& part = parts_[*number];
    const bool is_unseen = landmark.last_seen_s < time_s - config_.unseen_s;
    if (isLookedAt(part)) {
      ++result.expected;
      result.unseen += is_unseen ? 1 : 0;
    }
    ++part.looked;
    part.seen += is_unseen ? 0 : 1;
  }
  return result;
}

/// Which part of the view a place lies in; nothing if it is out of view.
std::optional<std::size_t> OldLandmarkWatch::partOf(
    const Eigen::Vector2d& p_sensor_landmark) const {
  const double range = p_sensor_landmark.norm() / config_.range_m;
  const double angle =
      std::atan2(p_sensor_landmark.y(), p_sensor_landmark.x()) / config_.half_angle_rad;
  if (range > 1.0 || std::abs(angle) > 1.0) return std::nullopt;
  const auto cell = [](double share, std::size_t cells) {
    return std::min(cells - 1, static_cast<std::size_t>(share * static_cast<double>(cells)));
  };
  return cell(range, kRings) * kSectors + cell(0.5 * (angle + 1.0), kSectors);
}

bool OldLandmarkWatch::isLookedAt(const Part& part) const {
  return part.looked >= kEnoughLooks && part.seen >= config_.seen_share * part.looked;
}

}  // namespace hymm::core
