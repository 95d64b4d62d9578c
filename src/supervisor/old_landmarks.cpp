#include "supervisor/old_landmarks.h"

#include <cmath>

namespace hymm::core {

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
                "... and this angle from the sensor's x axis");
}

OldLandmarksInView countOldLandmarksInView(const std::vector<LandmarkEstimate>& landmarks,
                                           const Pose2& T_map_sensor, double time_s,
                                           const OldLandmarkConfig& config) {
  const Pose2 T_sensor_map = inverse(T_map_sensor);
  OldLandmarksInView result;
  for (const LandmarkEstimate& landmark : landmarks) {
    if (landmark.first_seen_s > time_s - config.age_s ||
        landmark.observations < config.least_observations) {
      continue;
    }
    const Eigen::Vector2d p = T_sensor_map * landmark.position;
    const bool is_in_view =
        p.norm() <= config.range_m && std::abs(std::atan2(p.y(), p.x())) <= config.half_angle_rad;
    if (!is_in_view) continue;
    ++result.expected;
    if (landmark.last_seen_s < time_s - config.unseen_s) ++result.unseen;
  }
  return result;
}

}  // namespace hymm::core
