#pragma once

#include <vector>

#include <Eigen/Core>

#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// A closed line along the sides of cells, by its corners in units of cells from map's origin; the
/// last leads back to the first.
using CellRing = std::vector<Eigen::Vector2i>;

/// Cells that hang together by their sides: the outline, counter-clockwise, and clockwise those of
/// its holes.
struct CellPolygon {
  CellRing outline;
  std::vector<CellRing> holes;
};

/// The outlines of all occupied cells (by trinaryOccupancy()). Rings touch themselves and each
/// other in single corners at most.
std::vector<CellPolygon> occupiedOutlines(const OccupancyImage& image);

}  // namespace hymm::core
