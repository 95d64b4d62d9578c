#include "hybrid_map/image_painter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

/// The cells of a row, from `first` to before `end`.
struct Span {
  int first, end;

  /// Leaves those whose value at_first + per_cell * x, x counted from 0, is at least 0.
  void keepWhereNotNegative(double at_zero, double per_cell) {
    if (per_cell == 0.0) {
      if (at_zero < 0.0) end = first;
      return;
    }
    const double zero = std::clamp(-at_zero / per_cell, -1e9, 1e9);
    if (per_cell > 0.0) {
      first = std::max(first, static_cast<int>(std::ceil(zero)));
    } else {
      end = std::min(end, static_cast<int>(std::floor(zero)) + 1);
    }
  }
};

/// Takes note of an occupied cell by its middle in map.
void addSpot(const Eigen::Vector2d& middle, float log_odds, const ImageTiles& tiles,
             const OccupancyImage& image, std::vector<OccupiedSpot>& spots) {
  const Eigen::Array2i cell =
      (middle / image.resolution_m).array().floor().cast<int>() - image.corner.array();
  const Eigen::Array2i size(image.width, image.height);
  if ((cell < 0).any() || (cell >= size).any()) return;
  if (!tiles.has(cell.x() / ImageTiles::kCells, cell.y() / ImageTiles::kCells)) return;
  spots.push_back({image.index(cell.x(), cell.y()), occupancyPercent(log_odds)});
}

}  // namespace

void paintLtr(const TriangularGrid& grid, const Triangle& triangle, const float* log_odds,
              const ImagePatch& part, OccupancyImage& image) {
  // Local coordinates change evenly along a row.
  const Triangle::Local per_cell = triangle.edgesInverse().col(0) * image.resolution_m;
  for (int y = part.y; y < part.y + part.height; ++y) {
    const Triangle::Local first = triangle.toLocal(image.centre(part.x, y));
    Span span{0, part.width};
    span.keepWhereNotNegative(first.x() + kBorderTolerance, per_cell.x());
    span.keepWhereNotNegative(first.y() + kBorderTolerance, per_cell.y());
    span.keepWhereNotNegative(1.0 - first.sum() + kBorderTolerance, -per_cell.sum());
    std::int8_t* row = image.cells.data() + image.index(part.x, y);
    for (int x = span.first; x < span.end; ++x) {
      const Triangle::Local cells = grid.toCells(first + x * per_cell);
      const int index = grid.index(static_cast<int>(cells.x()), static_cast<int>(cells.y()));
      const std::int8_t percent = occupancyPercent(log_odds[index]);
      if (percent != OccupancyImage::kUnknown) row[x] = percent;
    }
  }
}

void findOccupied(const TriangularGrid& grid, const Triangle& triangle, const float* log_odds,
                  const ImageTiles& tiles, const OccupancyImage& image,
                  std::vector<OccupiedSpot>& spots) {
  for (int j = 0; j < grid.betaCells(); ++j) {
    for (int i = 0; i < grid.rowLength(j); ++i, ++log_odds) {
      if (*log_odds <= 0.0F) continue;
      Triangle::Local middle((i + 0.5) / grid.alphaCells(), (j + 0.5) / grid.betaCells());
      // Of a cell at the third side, the middle of what lies inside.
      middle.array() -= 0.5 * std::max(0.0, middle.sum() - 1.0);
      addSpot(triangle.toGlobal(middle), *log_odds, tiles, image, spots);
    }
  }
}

void findOccupied(const WaitingSquare& square, const ImageTiles& tiles, const OccupancyImage& image,
                  std::vector<OccupiedSpot>& spots) {
  const float* log_odds = square.log_odds;
  for (int j = 0; j < square.edge; ++j) {
    for (int i = 0; i < square.edge; ++i, ++log_odds) {
      if (*log_odds <= 0.0F) continue;
      const Eigen::Vector2d middle = square.resolution_m * Eigen::Vector2d(i + 0.5, j + 0.5);
      addSpot(square.T_map_cells * middle, *log_odds, tiles, image, spots);
    }
  }
}

void addSquare(const WaitingSquare& square, const ImagePatch& part, const OccupancyImage& image,
               std::vector<float>& log_odds) {
  const Pose2 T_cells_map = inverse(square.T_map_cells);
  const double scale = 1.0 / square.resolution_m;
  const Eigen::Vector2d per_cell = scale * image.resolution_m * T_cells_map.rotation().col(0);
  for (int y = 0; y < part.height; ++y) {
    const Eigen::Vector2d first = scale * (T_cells_map * image.centre(part.x, part.y + y));
    Span span{0, part.width};
    for (int axis = 0; axis < 2; ++axis) {
      span.keepWhereNotNegative(first[axis], per_cell[axis]);
      span.keepWhereNotNegative(square.edge - first[axis], -per_cell[axis]);
    }
    for (int x = span.first; x < span.end; ++x) {
      const Eigen::Vector2d place = first + x * per_cell;
      const int i = std::clamp(static_cast<int>(place.x()), 0, square.edge - 1);
      const int j = std::clamp(static_cast<int>(place.y()), 0, square.edge - 1);
      log_odds[std::size_t(y) * std::size_t(part.width) + std::size_t(x)] +=
          square.log_odds[j * square.edge + i];
    }
  }
}

}  // namespace hymm::core
