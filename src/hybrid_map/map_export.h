#pragma once

#include <string>

#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// Occupancy in files that other programs read. All throw OutputError, which names the file and
/// says why, if it cannot be written, or if there is nothing to write. Whoever reads a file while
/// it is written again finds the whole of the one before or of the new one; a failure leaves the
/// one before.

/// What map_server makes of a percentage by the thresholds that the files state: 100 (occupied), 0
/// (free), or -1 (in between, or unknown).
std::int8_t trinaryOccupancy(std::int8_t percent);

/// `path_without_extension`.pgm and .yaml, which map_server, map_saver's reverse, reads in mode
/// `trinary`: it gives back trinaryOccupancy() of each cell. Neither replaces the one before until
/// both are written.
void exportPgm(const OccupancyImage& image, const std::string& path_without_extension);

/// A binary OctoMap (.bt), which octovis shows and octomap::OcTree::readBinary reads: a layer of
/// voxels as high as a cell is wide, from z = 0 up, of all cells that are occupied or free by
/// trinaryOccupancy(). Its voxels are the image's cells. An OcTree reaches 32 768 cells from map's
/// origin to each side; an image that reaches farther is refused.
void exportOctoMap(const OccupancyImage& image, const std::string& path);

}  // namespace hymm::core
