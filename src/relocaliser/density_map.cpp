#include "relocaliser/density_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/LU>

#include "common/angles.h"

namespace hymm::core {
namespace {

// Deviations of observations are rounded up to powers of this.
constexpr double kClassRatio = 1.3;

// A cell is this share of the smallest deviation, so that the nearest one will do: its rounding
// adds 2 % to the variance.
constexpr double kCellShare = 0.5;
constexpr double kMaxCells = 2.0e6;

double leastVariance(const Eigen::Matrix2d& P) { return P.trace() - greatestVariance(P); }

LookupGrid gridAround(const std::vector<LocalLandmark>& landmarks, double least_m,
                      double greatest_m) {
  Eigen::AlignedBox2d box;
  double finest_m2 = std::numeric_limits<double>::infinity();
  for (const LocalLandmark& landmark : landmarks) {
    const double reach_m =
        kDensityReach * std::sqrt(greatestVariance(landmark.covariance) + greatest_m * greatest_m);
    box.extend(landmark.position - Eigen::Vector2d::Constant(reach_m));
    box.extend(landmark.position + Eigen::Vector2d::Constant(reach_m));
    finest_m2 = std::min(finest_m2, leastVariance(landmark.covariance));
  }
  if (landmarks.empty()) return {};
  const double finest_m = kCellShare * std::sqrt(std::max(0.0, finest_m2) + least_m * least_m);
  const double cell_m = std::max(finest_m, std::sqrt(box.volume() / kMaxCells));
  // One more cell on each side, which holds nothing: what lies beyond the border falls there.
  const Eigen::Vector2d corner = box.min() - Eigen::Vector2d::Constant(cell_m);
  const Eigen::Vector2d cells = box.sizes() / cell_m + Eigen::Vector2d::Constant(3.0);
  return {static_cast<float>(corner.x()), static_cast<float>(corner.y()),
          static_cast<float>(1.0 / cell_m), static_cast<std::int32_t>(cells.x()),
          static_cast<std::int32_t>(cells.y())};
}

}  // namespace

double greatestVariance(const Eigen::Matrix2d& P) {
  const double half = 0.5 * P.trace();
  return half + std::sqrt(std::max(0.0, half * half - P.determinant()));
}

double clutterPerM2(std::size_t points, double view_m2, const DensityConfig& config) {
  return config.clutter_share / (1.0 - config.clutter_share) * static_cast<double>(points) /
         view_m2;
}

void DensityConfig::describe(ConfigSchema& schema) {
  schema.number("clutter_share", clutter_share, Range::between(0.01, 0.95),
                "share of the observations that are of nothing in the map");
  schema.number("min_deviation_m", min_deviation_m, Range{0.01, 5.0},
                "the place of an observation is taken to be no better known than this");
}

double roundedUpDeviation(double deviation_m) {
  return std::pow(kClassRatio, std::ceil(std::log(deviation_m) / std::log(kClassRatio) - 1e-9));
}

std::vector<ObservedPoint> observedPoints(const ObservationSet& set, double min_deviation_m) {
  std::vector<ObservedPoint> points;
  for (const Observation& observation : set.observations) {
    const Eigen::Vector2d in_sensor =
        observation.range_m *
        Eigen::Vector2d(std::cos(observation.bearing_rad), std::sin(observation.bearing_rad));
    const double along_m = std::sqrt(observation.covariance(0, 0));
    const double across_m = observation.range_m * std::sqrt(observation.covariance(1, 1));
    const double deviation_m = std::max({along_m, across_m, min_deviation_m});
    if (!in_sensor.allFinite() || !std::isfinite(deviation_m)) continue;
    points.push_back({(set.T_base_sensor * in_sensor).cast<float>(),
                      roundedUpDeviation(deviation_m), observation.range_m});
  }
  return points;
}

DensityMap::DensityMap(const std::vector<LocalLandmark>& landmarks,
                       const std::vector<ObservedPoint>& points, double view_m2,
                       const DensityConfig& config) {
  if (points.empty()) return;
  const auto [least, greatest] = std::minmax_element(
      points.begin(), points.end(),
      [](const auto& a, const auto& b) { return a.deviation_m < b.deviation_m; });
  const double least_m = least->deviation_m;
  grid_ = gridAround(landmarks, least_m, greatest->deviation_m);
  const double clutter_per_m2 = clutterPerM2(points.size(), view_m2, config);
  const auto cells = static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height);
  std::map<double, std::size_t> table_of_deviation;
  std::vector<std::size_t> table_of_point;
  for (const ObservedPoint& point : points) {
    const auto [entry, is_new] = table_of_deviation.try_emplace(point.deviation_m, tables_.size());
    table_of_point.push_back(entry->second);
    if (!is_new) continue;
    std::vector<std::size_t> touched;
    std::vector<float>& table = tables_.emplace_back(cells, 0.0F);
    for (const LocalLandmark& landmark : landmarks) {
      addLandmark(landmark, point.deviation_m * point.deviation_m, 1.0 / clutter_per_m2, table,
                  touched);
    }
    for (const std::size_t cell : touched) table[cell] = std::log1p(table[cell]);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    lookups_.push_back({points[i].p_base_point.x(), points[i].p_base_point.y(),
                        tables_[table_of_point[i]].data()});
  }
}

void DensityMap::addLandmark(const LocalLandmark& landmark, double variance_m2, double per_clutter,
                             std::vector<float>& table, std::vector<std::size_t>& touched) const {
  const Eigen::Matrix2d S = landmark.covariance + variance_m2 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d S_inverse = S.inverse();
  const double peak = per_clutter / (2.0 * kPi * std::sqrt(S.determinant()));
  const double reach_m = kDensityReach * std::sqrt(greatestVariance(S));
  const double cell = cell_m();
  const Eigen::Vector2d origin(static_cast<double>(grid_.origin_x_m),
                               static_cast<double>(grid_.origin_y_m));
  const Eigen::Vector2d centre = (landmark.position - origin) / cell;
  const auto least = [&](double value) {
    return std::max(1, static_cast<int>(std::floor(value - reach_m / cell)));
  };
  const auto greatest = [&](double value, std::int32_t size) {
    return std::min(size - 2, static_cast<int>(std::ceil(value + reach_m / cell)));
  };
  for (int v = least(centre.y()); v <= greatest(centre.y(), grid_.height); ++v) {
    for (int u = least(centre.x()); u <= greatest(centre.x(), grid_.width); ++u) {
      const Eigen::Vector2d offset = cell * (Eigen::Vector2d(u + 0.5, v + 0.5) - centre);
      const double distance2 = offset.dot(S_inverse * offset);
      if (distance2 > kDensityReach * kDensityReach) continue;
      const std::size_t cell_index =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(grid_.width) +
          static_cast<std::size_t>(u);
      if (table[cell_index] == 0.0F) touched.push_back(cell_index);
      table[cell_index] += static_cast<float>(peak * std::exp(-0.5 * distance2));
    }
  }
}

double DensityMap::logValueAt(std::size_t point, const Eigen::Vector2d& p_local_point) const {
  const auto cell = [](double value, float origin, float per_m, std::int32_t size) {
    const double place = (value - static_cast<double>(origin)) * static_cast<double>(per_m);
    return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(size - 1)));
  };
  const std::size_t u = cell(p_local_point.x(), grid_.origin_x_m, grid_.cells_per_m, grid_.width);
  const std::size_t v = cell(p_local_point.y(), grid_.origin_y_m, grid_.cells_per_m, grid_.height);
  return static_cast<double>(lookups_[point].table[v * static_cast<std::size_t>(grid_.width) + u]);
}

double logLikelihoodAt(const Pose2& pose, const std::vector<LocalLandmark>& landmarks,
                       const std::vector<ObservedPoint>& points, double view_m2,
                       const DensityConfig& config) {
  const double clutter_per_m2 = clutterPerM2(points.size(), view_m2, config);
  double sum = 0.0;
  for (const ObservedPoint& point : points) {
    const Eigen::Vector2d place = pose * point.p_base_point.cast<double>();
    const double variance_m2 = point.deviation_m * point.deviation_m;
    double density = 0.0;
    for (const LocalLandmark& landmark : landmarks) {
      const Eigen::Matrix2d S = landmark.covariance + variance_m2 * Eigen::Matrix2d::Identity();
      const Eigen::Vector2d offset = place - landmark.position;
      const double distance2 = offset.dot(S.inverse() * offset);
      if (distance2 > kDensityReach * kDensityReach) continue;
      density += std::exp(-0.5 * distance2) / (2.0 * kPi * std::sqrt(S.determinant()));
    }
    sum += std::log1p(density / clutter_per_m2);
  }
  return sum;
}

}  // namespace hymm::core
