#include "cekf/cekf_slam_config.h"

namespace hymm::core {

void CekfSlamConfig::describe(ConfigSchema& schema) {
  schema.text("motion_input", motion_input,
              "what moves the filter: an Ackermann vehicle's encoders, or the twist of odometry",
              {"dead_reckoning", "odom"});
  schema.text("observation_input", observation_input,
              "laser scans, or landmarks that the robot detects itself", {"scan", "detections"});
  schema.number("landmark_block_range_m", landmark_block_range_m, Range::between(0.0, 1000.0),
                "cross-covariances are published for pairs of landmarks no farther apart");
  schema.number("landmark_rate_hz", landmark_rate_hz, Range{0.0, 100.0, true},
                "highest rate of the whole landmark map");
  schema.group("merger", merger);
  schema.group("perception", perception);
}

}  // namespace hymm::core
