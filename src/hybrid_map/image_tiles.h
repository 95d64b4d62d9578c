#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// A rectangle of cells of an image, by its least cell.
struct ImagePatch {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The cells of a patch, row by row.
std::vector<std::int8_t> cutOut(const OccupancyImage& image, const ImagePatch& patch);

/// Four corners of a convex region in map [m], in order; a triangle repeats its last one.
using ConvexRegion = std::array<Eigen::Vector2d, 4>;

/// Flags of the square tiles that an image is made of, counted from its least corner.
class ImageTiles {
 public:
  static constexpr int kCells = 32;  ///< along the side of a tile

  ImageTiles(int columns, int rows)
      : columns_(columns), flags_(std::size_t(columns) * std::size_t(rows), 0) {}

  int columns() const { return columns_; }
  int rows() const { return columns_ > 0 ? static_cast<int>(flags_.size()) / columns_ : 0; }
  bool has(int x, int y) const { return flags_[index(x, y)] != 0; }
  void set(int x, int y, bool flag) { flags_[index(x, y)] = flag ? 1 : 0; }

  /// Flags all tiles of an image that a region touches.
  void setUnder(const ConvexRegion& region, const OccupancyImage& image);

  /// The flagged tiles of row `y` from `first` to before `end`: calls `visit(x, count)` for each
  /// run of them.
  template <class Visitor>
  void visitRuns(int y, int first, int end, Visitor&& visitor) const {
    for (int x = first; x < end;) {
      int stop = x;
      while (stop < end && has(stop, y)) ++stop;
      if (stop > x) visitor(x, stop - x);
      x = std::max(stop, x + 1);
    }
  }

  /// Calls `visit(x, y)` for each flagged tile.
  template <class Visitor>
  void visit(Visitor&& visitor) const {
    for (int y = 0; y < rows(); ++y) {
      for (int x = 0; x < columns_; ++x) {
        if (has(x, y)) visitor(x, y);
      }
    }
  }

  static ImagePatch patchOf(int x, int y, int columns = 1) {
    return {x * kCells, y * kCells, columns * kCells, kCells};
  }

  /// All flagged tiles as few rectangles.
  std::vector<ImagePatch> patches() const;

 private:
  std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(columns_) + std::size_t(x);
  }

  int columns_;
  std::vector<char> flags_;
};

/// Tiles of a row that a region touches, from `first` to before `end`.
struct TileRow {
  int y, first, end;
};

/// The tiles of an image that a region touches, with a cell to spare around it.
std::vector<TileRow> tilesUnder(const ConvexRegion& region, const OccupancyImage& image);

}  // namespace hymm::core
