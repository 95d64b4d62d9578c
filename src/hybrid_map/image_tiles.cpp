#include "hybrid_map/image_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// Of the part of a convex region between two heights: its extent along x.
Interval extentBetween(const ConvexRegion& region, double low_y, double high_y) {
  Interval extent;
  for (std::size_t k = 0; k < region.size(); ++k) {
    const Eigen::Vector2d& a = region[k];
    const Eigen::Vector2d& b = region[(k + 1) % region.size()];
    if (a.y() >= low_y && a.y() <= high_y) extent.extend(a.x());
    for (const double y : {low_y, high_y}) {
      if ((a.y() < y) == (b.y() < y)) continue;
      extent.extend(a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()));
    }
  }
  return extent;
}

int clampedFloor(double value, int low, int high) {
  return static_cast<int>(std::clamp(std::floor(value), double(low), double(high)));
}

}  // namespace

std::vector<std::int8_t> cutOut(const OccupancyImage& image, const ImagePatch& patch) {
  std::vector<std::int8_t> cells;
  cells.reserve(std::size_t(patch.width) * std::size_t(patch.height));
  for (int y = patch.y; y < patch.y + patch.height; ++y) {
    const auto row = image.cells.begin() + std::ptrdiff_t(image.index(patch.x, y));
    cells.insert(cells.end(), row, row + patch.width);
  }
  return cells;
}

void ImageTiles::setUnder(const ConvexRegion& region, const OccupancyImage& image) {
  for (const TileRow& row : tilesUnder(region, image)) {
    for (int x = row.first; x < row.end; ++x) set(x, row.y, true);
  }
}

std::vector<TileRow> tilesUnder(const ConvexRegion& region, const OccupancyImage& image) {
  constexpr int kCells = ImageTiles::kCells;
  constexpr double kSpare = 1.0;  // cells
  const int columns = image.width / kCells, rows = image.height / kCells;
  ConvexRegion cells;  // in units of the image's cells
  Interval heights;
  for (std::size_t k = 0; k < region.size(); ++k) {
    cells[k] = region[k] / image.resolution_m - image.corner.cast<double>();
    heights.extend(cells[k].y());
  }
  std::vector<TileRow> under;
  const int first_row = clampedFloor((heights.low - kSpare) / kCells, 0, rows);
  const int end_row = clampedFloor((heights.high + kSpare) / kCells, -1, rows - 1) + 1;
  for (int y = first_row; y < end_row; ++y) {
    const Interval extent = extentBetween(cells, y * kCells - kSpare, (y + 1) * kCells + kSpare);
    const int first = clampedFloor((extent.low - kSpare) / kCells, 0, columns);
    const int end = clampedFloor((extent.high + kSpare) / kCells, -1, columns - 1) + 1;
    if (first < end) under.push_back({y, first, end});
  }
  return under;
}

// Runs along x; a run that continues one of the row before makes it higher.
std::vector<ImagePatch> ImageTiles::patches() const {
  std::vector<ImagePatch> patches;
  std::vector<std::size_t> above;  // runs of the row before
  for (int y = 0; y < rows(); ++y) {
    std::vector<std::size_t> here;
    visitRuns(y, 0, columns_, [&](int x, int count) {
      const ImagePatch run = patchOf(x, y, count);
      const auto same = std::find_if(above.begin(), above.end(), [&](std::size_t i) {
        return patches[i].x == run.x && patches[i].width == run.width;
      });
      if (same != above.end()) {
        patches[*same].height += run.height;
        here.push_back(*same);
      } else {
        here.push_back(patches.size());
        patches.push_back(run);
      }
    });
    above = std::move(here);
  }
  return patches;
}

}  // namespace hymm::core
