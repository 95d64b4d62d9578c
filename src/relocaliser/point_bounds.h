#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relocaliser/local_map.h"

namespace hymm::core {

/// Cells over the plane.
struct Raster {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double cell_m = 1.0;
  double per_m = 1.0;  ///< cells
  std::int64_t width = 0, height = 0;

  Raster() = default;
  Raster(const Eigen::AlignedBox2d& box, double cell);

  std::size_t size() const { return static_cast<std::size_t>(width * height); }
  /// -1 beyond the border.
  std::int64_t cellOf(const Eigen::Vector2d& place) const {
    const double u = (place.x() - origin.x()) * per_m, v = (place.y() - origin.y()) * per_m;
    if (!(u >= 0.0 && v >= 0.0 && u < static_cast<double>(width) &&
          v < static_cast<double>(height))) {
      return -1;
    }
    return static_cast<std::int64_t>(v) * width + static_cast<std::int64_t>(u);
  }
  /// Calls `visit(cell, centre)` for all cells whose centre is within `radius_m`, and some more.
  template <class Visit>
  void visitAround(const Eigen::Vector2d& place, double radius_m, Visit visit) const {
    const auto bounds = [&](double value, std::int64_t count) {
      const auto limit = static_cast<double>(count - 1);
      return std::pair(
          static_cast<std::int64_t>(std::clamp((value - radius_m) / cell_m, 0.0, limit)),
          static_cast<std::int64_t>(std::clamp((value + radius_m) / cell_m, 0.0, limit)));
    };
    const Eigen::Vector2d at = place - origin;
    const auto [u0, u1] = bounds(at.x(), width);
    const auto [v0, v1] = bounds(at.y(), height);
    for (std::int64_t v = v0; v <= v1; ++v) {
      for (std::int64_t u = u0; u <= u1; ++u) {
        const Eigen::Vector2d middle(static_cast<double>(u) + 0.5, static_cast<double>(v) + 0.5);
        visit(static_cast<std::size_t>(v * width + u), Eigen::Vector2d(origin + cell_m * middle));
      }
    }
  }
};

/// A landmark as points of one deviation see it: by how many times its density exceeds clutter's.
struct DensityKernel {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d S_inverse = Eigen::Matrix2d::Identity();
  double peak = 0.0;
  double least_m = 0.0;     ///< deviations, along the axes
  double greatest_m = 0.0;  ///< of the ellipse

  DensityKernel(const LocalLandmark& landmark, double deviation_m, double clutter_per_m2);

  /// The most that it is at any place within `radius_m` of this one.
  double greatestWithin(const Eigen::Vector2d& place, double radius_m) const;
  /// Beyond it there is nothing.
  double reach_m() const;
};

/// Bounds on what an observed point is worth, as a log likelihood, anywhere within a radius of a
/// place.
class PointBounds {
 public:
  PointBounds(const std::vector<LocalLandmark>& landmarks, const std::vector<double>& deviations_m,
              double clutter_per_m2);

  const Eigen::AlignedBox2d& landmarkBox() const { return box_; }
  double reach_m() const { return reach_m_; }

  /// For points of the deviation of that number, anywhere.
  double greatest(std::size_t deviation) const;

  /// A table for each deviation, and then one for any of them, for boxes in which points move by up
  /// to `radius_m`; empty if they would need cells larger than that.
  struct Tables {
    Raster raster;
    double widened_m = 0.0;                  ///< the radius around a cell's centre
    std::vector<std::vector<float>> values;  ///< by deviation; the last: the greatest of them
    std::size_t steps = 0;                   ///< done by fill()
  };
  /// Still to be filled.
  Tables tables(double radius_m) const;
  /// One step: enters a landmark, or finishes some cells. Gives the number of cells that it took
  /// care of; nothing if all was done.
  std::optional<std::size_t> fill(Tables& tables) const;

  /// To be called before near(): for radii up to this.
  void prepareNear(double radius_m);
  /// For points of the deviation of that number.
  double near(std::size_t deviation, const Eigen::Vector2d& place, double radius_m) const;

 private:
  static void finishCells(Tables& tables, std::size_t deviation, std::size_t first,
                          std::size_t end);
  std::size_t enter(const DensityKernel& kernel, const Tables& tables,
                    std::vector<float>& table) const;
  /// Where landmarks have an effect.
  Eigen::AlignedBox2d widened(double by_m) const;

  std::vector<std::vector<DensityKernel>> kernels_;  ///< by deviation and landmark
  double reach_m_ = 0.0;
  Eigen::AlignedBox2d box_;
  Raster buckets_raster_;
  std::vector<std::vector<std::size_t>> buckets_;  ///< landmarks that may be near
};

}  // namespace hymm::core
