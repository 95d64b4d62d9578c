#pragma once

#include <algorithm>
#include <sstream>
#include <string>

#include <Eigen/Core>

#include "hybrid_map/map_export.h"
#include "hybrid_map/occupancy_image.h"
#include "simulation/truth.h"

namespace hymm::core {

/// How much of what a map calls free is solid in truth, and how far inside.
class FreeCells {
 public:
  /// `truth`: cells of the image's size, solid where a solid thing is within half a cell of their
  /// middle; `fine`: the same world in cells so small that they tell what is at a place.
  FreeCells(const TrueOccupancy& truth, const TrueOccupancy& fine) : truth_(truth), fine_(fine) {}

  /// Shares of the free cells within the true world, as JSON.
  std::string text(const std::string& name, const OccupancyImage& image) const {
    double free = 0.0, solid = 0.0, solid_at_middle = 0.0, deep = 0.0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Eigen::Vector2d middle = image.centre(x, y);
        if (image.at(x, y) == OccupancyImage::kUnknown || trinaryOccupancy(image.at(x, y)) != 0 ||
            !isInside(truth_, middle)) {
          continue;
        }
        free += 1.0;
        solid += isSolid(truth_, middle) ? 1.0 : 0.0;
        if (!isSolid(fine_, middle)) continue;
        solid_at_middle += 1.0;
        deep += isDeep(middle, image.resolution_m) ? 1.0 : 0.0;
      }
    }
    const double all = std::max(1.0, free);
    std::ostringstream text;
    text << "  \"" << name << "_free_cells\": " << free << ",\n  \"" << name
         << "_free_share_solid\": " << solid / all << ",\n  \"" << name
         << "_free_share_solid_at_middle\": " << solid_at_middle / all << ",\n  \"" << name
         << "_free_share_solid_a_cell_deep\": " << deep / all << ",\n";
    return text.str();
  }

 private:
  static Eigen::Array2i cellOf(const TrueOccupancy& truth, const Eigen::Vector2d& place) {
    return ((place - truth.origin) / truth.resolution_m).array().floor().cast<int>();
  }
  static bool isInside(const TrueOccupancy& truth, const Eigen::Vector2d& place) {
    const Eigen::Array2i cell = cellOf(truth, place);
    return (cell >= 0).all() && cell.x() < truth.width && cell.y() < truth.height;
  }
  static bool isSolid(const TrueOccupancy& truth, const Eigen::Vector2d& place) {
    if (!isInside(truth, place)) return false;
    const Eigen::Array2i cell = cellOf(truth, place);
    return truth.occupied[std::size_t(cell.y()) * std::size_t(truth.width) + std::size_t(cell.x())];
  }
  /// Whether all around is solid, too.
  bool isDeep(const Eigen::Vector2d& middle, double reach_m) const {
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (!isSolid(fine_, middle + reach_m * Eigen::Vector2d(i, j))) return false;
      }
    }
    return true;
  }

  const TrueOccupancy &truth_, &fine_;
};

}  // namespace hymm::core
