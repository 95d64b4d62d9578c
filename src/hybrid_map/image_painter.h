#pragma once

#include <vector>

#include "common/pose2.h"
#include "hybrid_map/image_tiles.h"
#include "hybrid_map/triangular_grid.h"

namespace hymm::core {

/// Draws the cells of an LTR where it is now into a part of an image. Cells of the image whose
/// centre lies outside of the LTR, or about which it knows nothing, stay as they are.
void paintLtr(const TriangularGrid& grid, const Triangle& triangle, const float* log_odds,
              const ImagePatch& part, OccupancyImage& image);

/// An occupied cell of an LTR, by the cell of the image in which its middle lies.
struct OccupiedSpot {
  std::size_t index = 0;  ///< in the image
  std::int8_t percent = 0;
};

/// All occupied cells of an LTR whose middle lies in flagged tiles. An image that looks only at the
/// middles of its own cells would lose some of them: a thin wall would have gaps.
void findOccupied(const TriangularGrid& grid, const Triangle& triangle, const float* log_odds,
                  const ImageTiles& tiles, const OccupancyImage& image,
                  std::vector<OccupiedSpot>& spots);

/// Square cells that wait for an LTR: `edge` x `edge` of them, the least corner of the first at
/// `T_map_cells` (in metres; the sheet's axes).
struct WaitingSquare {
  Pose2 T_map_cells;
  double resolution_m = 0.0;
  int edge = 0;
  const float* log_odds = nullptr;
};

/// Those that are occupied, as findOccupied().
void findOccupied(const WaitingSquare& square, const ImageTiles& tiles, const OccupancyImage& image,
                  std::vector<OccupiedSpot>& spots);

/// Adds their log-odds to those of the cells of a part of an image, row by row.
void addSquare(const WaitingSquare& square, const ImagePatch& part, const OccupancyImage& image,
               std::vector<float>& log_odds);

}  // namespace hymm::core
