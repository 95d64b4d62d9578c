#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "door_planner/ltr_view.h"
#include "test/support/planner_meshes.h"

namespace hymm::benchmarks {

/// Trees and bushes at random on a square: discs of 0.2 to 2 m radius, one per 200 m^2.
class DiscWorld {
 public:
  DiscWorld(double extent_m, std::uint64_t seed);

  struct Disc {
    Eigen::Vector2d centre;
    double radius_m;
  };
  const std::vector<Disc>& discs() const { return discs_; }
  double extent_m() const { return extent_m_; }

  /// Distance of a point from the nearest disc's border, at most `limit_m`.
  double clearance(const Eigen::Vector2d& point, double limit_m) const;

  /// Occupancy of the cells of an LTR whose centres lie in a disc.
  core::LtrContent contentOf(const core::LtrView& ltr) const;

  /// Calls `visit(disc)` for those that touch a box.
  template <class Visitor>
  void visit(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Visitor&& visitor) const {
    const int x0 = bucketOf(low.x() - kLargest_m), x1 = bucketOf(high.x() + kLargest_m);
    const int y0 = bucketOf(low.y() - kLargest_m), y1 = bucketOf(high.y() + kLargest_m);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        for (const int disc : buckets_[std::size_t(y * columns_ + x)]) {
          visitor(discs_[std::size_t(disc)]);
        }
      }
    }
  }

 private:
  static constexpr double kLargest_m = 2.0;
  static constexpr double kBucket_m = 10.0;
  int bucketOf(double coordinate) const;

  double extent_m_;
  int columns_;
  std::vector<Disc> discs_;
  std::vector<std::vector<int>> buckets_;
};

/// A mesh over the world with sides that meet at right angles, nearly, of at most 80 cells.
test::SquareMesh meshOver(const DiscWorld& world, double resolution_m);

}  // namespace hymm::benchmarks
