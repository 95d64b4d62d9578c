#pragma once

#include <optional>
#include <string>

#include "common/config.h"
#include "common/pose2.h"

namespace hymm {

/// The parameters `saved_map/…`: a map that the suite begins with.
struct SavedMapConfig {
  std::string folder;  ///< empty: none
  bool localise_only = false;
  std::string pose;  ///< of base_link, "X Y YAW" in m and rad; empty: where it was at the end

  void describe(core::ConfigSchema& schema);

  /// `pose` as numbers; nothing if it is empty. A sentence is added to `report` where it is
  /// neither.
  std::optional<core::Pose2> startPose(const std::string& origin, core::ConfigReport& report) const;
};

}  // namespace hymm
