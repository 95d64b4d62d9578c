#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hybrid_map/triangular_grid.h"

namespace hymm::core {

/// Occupancy of an LTR compressed with loss (paper, III.D): cells above a threshold are occupied,
/// all others that were ever seen are free, and a quadtree over the cells holds which. It is
/// written as OctoMap's binary form writes an octree, two bits a node: unknown, free, occupied, or
/// four children. Cells of a kind come back with the mean of their log-odds, so that the sum over
/// all cells is kept, and compressing what came back loses nothing more.
class OccupancyQuadtree {
 public:
  OccupancyQuadtree() = default;
  /// `log_odds`: of all cells of the grid; 0 is unknown. Those above `threshold` are occupied.
  OccupancyQuadtree(const TriangularGrid& grid, const std::vector<float>& log_odds,
                    float threshold);

  bool isEmpty() const { return nodes_.empty(); }
  std::vector<float> unpack() const;

  std::size_t bytes() const;
  std::size_t unpackedBytes() const;

 private:
  int alpha_cells_ = 0, beta_cells_ = 0;
  std::array<float, 3> log_odds_{};  ///< of unknown, free and occupied cells
  std::vector<std::uint8_t> nodes_;  ///< four to a byte, parents before their children
};

}  // namespace hymm::core
