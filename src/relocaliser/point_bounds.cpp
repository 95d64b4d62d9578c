#include "relocaliser/point_bounds.h"

#include <cmath>

#include <Eigen/LU>

#include "common/angles.h"
#include "relocaliser/density_map.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

// Tables have cells of a third of the radius that they are for, or larger ones.
constexpr double kCellShare = 1.0 / 3.0;
constexpr double kMostCells = 1e6;

// Of whose values logarithms are taken in one step.
constexpr std::size_t kCellsAtOnce = 65536;

// Of the grid that tells which landmarks are near a place.
constexpr double kLeastBucket_m = 2.0;
constexpr double kMostBuckets = 1e5;

}  // namespace

Raster::Raster(const Eigen::AlignedBox2d& box, double cell)
    : origin(box.min()),
      cell_m(cell),
      per_m(1.0 / cell),
      width(static_cast<std::int64_t>(box.sizes().x() / cell) + 1),
      height(static_cast<std::int64_t>(box.sizes().y() / cell) + 1) {}

DensityKernel::DensityKernel(const LocalLandmark& landmark, double deviation_m,
                             double clutter_per_m2)
    : position(landmark.position) {
  const Eigen::Matrix2d S =
      landmark.covariance + deviation_m * deviation_m * Eigen::Matrix2d::Identity();
  S_inverse = S.inverse();
  peak = 1.0 / (2.0 * kPi * std::sqrt(S.determinant()) * clutter_per_m2);
  greatest_m = std::sqrt(greatestVariance(S));
  least_m = std::sqrt(S.trace() - greatestVariance(S));
}

/// The distance in deviations falls by no more than radius / least deviation, and is no less than
/// that of a round one.
double DensityKernel::greatestWithin(const Vector2d& place, double radius_m) const {
  const Vector2d d = place - position;
  const double deviations = std::max({0.0, std::sqrt(d.dot(S_inverse * d)) - radius_m / least_m,
                                      (d.norm() - radius_m) / greatest_m});
  return deviations > kDensityReach ? 0.0 : peak * std::exp(-0.5 * deviations * deviations);
}

double DensityKernel::reach_m() const { return kDensityReach * greatest_m; }

PointBounds::PointBounds(const std::vector<LocalLandmark>& landmarks,
                         const std::vector<double>& deviations_m, double clutter_per_m2) {
  for (const double deviation_m : deviations_m) {
    kernels_.emplace_back();
    for (const LocalLandmark& landmark : landmarks) {
      kernels_.back().emplace_back(landmark, deviation_m, clutter_per_m2);
      reach_m_ = std::max(reach_m_, kernels_.back().back().reach_m());
    }
  }
  for (const LocalLandmark& landmark : landmarks) box_.extend(landmark.position);
}

double PointBounds::greatest(std::size_t deviation) const {
  double sum = 0.0;
  for (const DensityKernel& kernel : kernels_[deviation]) sum += kernel.peak;
  return std::log1p(sum);
}

PointBounds::Tables PointBounds::tables(double radius_m) const {
  Tables tables;
  const Eigen::AlignedBox2d box = widened(radius_m * (1.0 + kCellShare));
  const double cell_m = std::max(kCellShare * radius_m, std::sqrt(box.sizes().prod() / kMostCells));
  if (cell_m > radius_m) return tables;
  tables.raster = Raster(box, cell_m);
  // A place is within half of the diagonal of its cell's centre.
  tables.widened_m = radius_m + cell_m * std::sqrt(0.5);
  tables.values.resize(kernels_.size() + 1);
  return tables;
}

/// For each deviation the landmarks come first, then the logarithms.
std::optional<std::size_t> PointBounds::fill(Tables& tables) const {
  const std::size_t cells = tables.raster.size();
  const std::size_t landmarks = kernels_.empty() ? 0 : kernels_.front().size();
  const std::size_t steps = landmarks + (cells + kCellsAtOnce - 1) / kCellsAtOnce;
  const std::size_t all = tables.values.empty() ? 0 : steps * kernels_.size();
  if (tables.steps >= all) return std::nullopt;
  const std::size_t deviation = tables.steps / steps, step = tables.steps % steps;
  ++tables.steps;
  std::vector<float>& table = tables.values[deviation];
  if (step == 0) table.assign(cells, 0.0F);
  if (tables.steps == 1) tables.values.back().assign(cells, 0.0F);
  if (step < landmarks) return enter(kernels_[deviation][step], tables, table);
  const std::size_t first = (step - landmarks) * kCellsAtOnce;
  const std::size_t end = std::min(cells, first + kCellsAtOnce);
  finishCells(tables, deviation, first, end);
  return end - first;
}

void PointBounds::finishCells(Tables& tables, std::size_t deviation, std::size_t first,
                              std::size_t end) {
  std::vector<float>&table = tables.values[deviation], &of_any = tables.values.back();
  for (std::size_t i = first; i < end; ++i) {
    if (table[i] == 0.0F) continue;
    table[i] = std::log1p(table[i]);
    of_any[i] = std::max(of_any[i], table[i]);
  }
}

std::size_t PointBounds::enter(const DensityKernel& kernel, const Tables& tables,
                               std::vector<float>& table) const {
  std::size_t cells = 0;
  tables.raster.visitAround(
      kernel.position, kernel.reach_m() + tables.widened_m,
      [&](std::size_t cell, const Vector2d& centre) {
        table[cell] += static_cast<float>(kernel.greatestWithin(centre, tables.widened_m));
        ++cells;
      });
  return cells;
}

void PointBounds::prepareNear(double radius_m) {
  const Eigen::AlignedBox2d box = widened(radius_m);
  buckets_raster_ =
      Raster(box, std::max(kLeastBucket_m, std::sqrt(box.sizes().prod() / kMostBuckets)));
  buckets_.assign(buckets_raster_.size(), {});
  const double far_m = reach_m_ + radius_m + buckets_raster_.cell_m * std::sqrt(0.5);
  for (std::size_t j = 0; !kernels_.empty() && j < kernels_.front().size(); ++j) {
    const Vector2d& position = kernels_.front()[j].position;
    buckets_raster_.visitAround(position, far_m, [&](std::size_t cell, const Vector2d& centre) {
      if ((centre - position).norm() <= far_m) buckets_[cell].push_back(j);
    });
  }
}

double PointBounds::near(std::size_t deviation, const Vector2d& place, double radius_m) const {
  const std::int64_t cell = buckets_raster_.cellOf(place);
  if (cell < 0) return 0.0;
  double sum = 0.0;
  for (const std::size_t j : buckets_[static_cast<std::size_t>(cell)]) {
    sum += kernels_[deviation][j].greatestWithin(place, radius_m);
  }
  return sum == 0.0 ? 0.0 : std::log1p(sum);
}

Eigen::AlignedBox2d PointBounds::widened(double by_m) const {
  const Vector2d margin = Vector2d::Constant(reach_m_ + by_m);
  return {Vector2d(box_.min() - margin), Vector2d(box_.max() + margin)};
}

}  // namespace hymm::core
