#include "benchmark/disc_world.h"

#include <algorithm>
#include <cmath>

#include "common/random.h"

namespace hymm::benchmarks {

DiscWorld::DiscWorld(double extent_m, std::uint64_t seed)
    : extent_m_(extent_m), columns_(static_cast<int>(extent_m / kBucket_m) + 1) {
  core::RandomGenerator generator(seed);
  const auto count = std::lround(extent_m * extent_m / 200.0);
  buckets_.resize(std::size_t(columns_) * std::size_t(columns_));
  for (long i = 0; i < count; ++i) {
    Disc disc;
    disc.centre.x() = core::sampleUniform(generator, 0.0, extent_m);
    disc.centre.y() = core::sampleUniform(generator, 0.0, extent_m);
    disc.radius_m = core::sampleUniform(generator, 0.2, kLargest_m);
    const int bucket = bucketOf(disc.centre.y()) * columns_ + bucketOf(disc.centre.x());
    buckets_[std::size_t(bucket)].push_back(static_cast<int>(discs_.size()));
    discs_.push_back(disc);
  }
}

int DiscWorld::bucketOf(double coordinate) const {
  return std::clamp(static_cast<int>(std::floor(coordinate / kBucket_m)), 0, columns_ - 1);
}

double DiscWorld::clearance(const Eigen::Vector2d& point, double limit_m) const {
  double nearest = limit_m;
  const Eigen::Vector2d around = Eigen::Vector2d::Constant(limit_m);
  visit(point - around, point + around, [&](const Disc& disc) {
    nearest = std::min(nearest, (point - disc.centre).norm() - disc.radius_m);
  });
  return nearest;
}

core::LtrContent DiscWorld::contentOf(const core::LtrView& ltr) const {
  const core::TriangularGrid grid = core::gridOf(ltr.alpha_cells, ltr.beta_cells);
  const core::Triangle triangle(ltr.corners);
  core::LtrContent content;
  content.occupancy.assign(std::size_t(grid.cellCount()), 0.0F);
  const core::Corners& c = ltr.corners;
  visit(c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]),
        [&](const Disc& disc) {
          const Eigen::Vector2d centre = grid.toCells(triangle.toLocal(disc.centre));
          const Eigen::Vector2d reach =
              grid.toCells(disc.radius_m * triangle.edgesInverse().rowwise().norm());
          const int j1 = std::min(grid.betaCells() - 1, static_cast<int>(centre.y() + reach.y()));
          for (int j = std::max(0, static_cast<int>(centre.y() - reach.y())); j <= j1; ++j) {
            const int i1 =
                std::min(grid.rowLength(j) - 1, static_cast<int>(centre.x() + reach.x()));
            for (int i = std::max(0, static_cast<int>(centre.x() - reach.x())); i <= i1; ++i) {
              const Eigen::Vector2d place =
                  triangle.toGlobal({(i + 0.5) / grid.alphaCells(), (j + 0.5) / grid.betaCells()});
              if ((place - disc.centre).norm() > disc.radius_m) continue;
              content.occupancy[std::size_t(grid.index(i, j))] = 1.0F;
            }
          }
        });
  return content;
}

test::SquareMesh meshOver(const DiscWorld& world, double resolution_m) {
  constexpr double kJitter_m = 0.4;
  const double edge_m = 80 * resolution_m - 2.0 * kJitter_m - 0.02;
  const int squares = static_cast<int>(std::ceil(world.extent_m() / edge_m));
  return {squares, squares, edge_m, resolution_m, kJitter_m, 1};
}

}  // namespace hymm::benchmarks
