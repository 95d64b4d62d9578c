#include "nodes/saved_map_config.h"

#include <cmath>
#include <sstream>

namespace hymm {

void SavedMapConfig::describe(core::ConfigSchema& schema) {
  schema.text("folder", folder, "of a saved map to begin with; empty: none");
  schema.flag("localise_only", localise_only, "that map stays as it is; else mapping goes on");
  schema.text("pose", pose,
              "of base_link in that map, as 'X Y YAW' in m and rad; empty: where it was when the "
              "map was saved");
}

std::optional<core::Pose2> SavedMapConfig::startPose(const std::string& origin,
                                                     core::ConfigReport& report) const {
  if (pose.find_first_not_of(" \t") == std::string::npos) return std::nullopt;
  std::istringstream words(pose);
  core::Pose2 start;
  std::string rest;
  const bool read(words >> start.x_m >> start.y_m >> start.yaw_rad);
  if (read && !(words >> rest) && start.vector().allFinite()) return start;
  report.errors.push_back(origin + ": pose is '" + pose +
                          "', but must be three numbers 'X Y YAW' in m, m and rad.");
  return std::nullopt;
}

}  // namespace hymm
