#pragma once

#include <string>
#include <vector>

#include <hymm/GridStatus.h>
#include <hymm/LtrGrid.h>
#include <hymm/LtrMap.h>
#include <hymm/PropertySample.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>

#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/map_image.h"
#include "pipeline/grid_files.h"

/// The dense map to messages and back. Headers are the caller's.
namespace hymm {

LtrMap toMessage(const std::vector<core::LtrTopology>& ltrs, std::uint64_t landmark_version);
std::vector<core::LtrTopology> fromMessage(const LtrMap& message);

/// A layer of an LTR that exists.
LtrGrid toMessage(const core::HybridMap& map, const core::ChangedLayer& changed);

nav_msgs::OccupancyGrid toMessage(const core::OccupancyImage& image);
map_msgs::OccupancyGridUpdate toMessage(const core::OccupancyImage& image,
                                        const core::ImagePatch& patch);

/// Why fromMessage() cannot make an image of a grid; empty if it can.
std::string problemOf(const nav_msgs::OccupancyGrid& message);
/// The image that a grid holds, which must have no problem.
core::OccupancyImage fromMessage(const nav_msgs::OccupancyGrid& message);
/// Writes an update into an image made of a grid; false, and nothing changes, where it does not
/// fit.
bool applyUpdate(const map_msgs::OccupancyGridUpdate& update, core::OccupancyImage& image);

/// The memory part of a status, and back.
void fillMemory(const core::GridMemory& memory, GridStatus& status);
core::GridMemory memoryOf(const GridStatus& status);

/// A sample whose position is in a frame that stands at `T_map_frame`.
core::PropertySample fromMessage(const PropertySample& message, const core::Pose2& T_map_frame);

}  // namespace hymm
