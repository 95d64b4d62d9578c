#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// An image of cells of 0.2 m, all of one content.
inline OccupancyImage imageOf(double low_x, double low_y, double high_x, double high_y,
                              std::int8_t percent) {
  OccupancyImage image;
  image.resolution_m = 0.2;
  image.corner = {static_cast<int>(std::lround(low_x / 0.2)),
                  static_cast<int>(std::lround(low_y / 0.2))};
  image.width = static_cast<int>(std::lround((high_x - low_x) / 0.2));
  image.height = static_cast<int>(std::lround((high_y - low_y) / 0.2));
  image.cells.assign(std::size_t(image.width) * std::size_t(image.height), percent);
  return image;
}
inline OccupancyImage freeImage(double low_x, double low_y, double high_x, double high_y) {
  return imageOf(low_x, low_y, high_x, high_y, 0);
}
inline OccupancyImage unknownImage(double low_x, double low_y, double high_x, double high_y) {
  return imageOf(low_x, low_y, high_x, high_y, OccupancyImage::kUnknown);
}

inline Eigen::Vector2i cellIn(const OccupancyImage& image, const Eigen::Vector2d& place) {
  const Eigen::Vector2i cell = (place / image.resolution_m).array().floor().cast<int>();
  return cell - image.corner;
}

/// Makes the cells occupied that a box touches.
inline void fillBox(OccupancyImage& image, double low_x, double low_y, double high_x,
                    double high_y) {
  const Eigen::Vector2i low = cellIn(image, {low_x, low_y}), high = cellIn(image, {high_x, high_y});
  for (int y = std::max(low.y(), 0); y <= std::min(high.y(), image.height - 1); ++y) {
    for (int x = std::max(low.x(), 0); x <= std::min(high.x(), image.width - 1); ++x) {
      image.cells[image.index(x, y)] = 100;
    }
  }
}

inline bool isOccupied(const OccupancyImage& image, const Eigen::Vector2d& place) {
  const Eigen::Vector2i cell = cellIn(image, place);
  return (cell.array() >= 0).all() && cell.x() < image.width && cell.y() < image.height &&
         image.at(cell.x(), cell.y()) == 100;
}

/// Whether a line comes within `margin_m` of an occupied cell.
inline bool passesNearOccupied(const OccupancyImage& image, const Eigen::Vector2d& from,
                               const Eigen::Vector2d& to, double margin_m) {
  const int samples = static_cast<int>((to - from).norm() / margin_m) + 1;
  for (int i = 0; i <= samples; ++i) {
    const Eigen::Vector2d at = from + (to - from) * (static_cast<double>(i) / samples);
    for (const double x : {-margin_m, margin_m}) {
      for (const double y : {-margin_m, margin_m}) {
        if (isOccupied(image, at + Eigen::Vector2d(x, y))) return true;
      }
    }
  }
  return false;
}

}  // namespace hymm::core
