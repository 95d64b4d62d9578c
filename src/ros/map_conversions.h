#pragma once

#include <string>

#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>

#include "cekf/landmark_map.h"

/// Landmark maps to messages and back.
namespace hymm {

/// `block_range_m`: the range up to which `map` has cross-covariances.
LandmarkMap toMessage(const core::LandmarkMap& map, double block_range_m,
                      const std::string& frame_id);
core::LandmarkMap fromMessage(const LandmarkMap& message);

LandmarkUpdate toMessage(const core::LandmarkUpdate& update, double time_s,
                         const std::string& frame_id);
core::LandmarkUpdate fromMessage(const LandmarkUpdate& message);

}  // namespace hymm
