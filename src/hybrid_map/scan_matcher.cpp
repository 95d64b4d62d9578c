#include "hybrid_map/scan_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "common/error.h"
#include "hybrid_map/input_check.h"
#include "hybrid_map/log_odds.h"
#include "hybrid_map/occupancy_field.h"
#include "perception/scan_check.h"

namespace hymm::core {
namespace {

// Of beams, that end anywhere: people, cars, what changed.
constexpr double kOutlierShare = 0.05;
// A beam that ends where the map knows nothing is likelier than one that ends in free space, and
// less likely than one on an obstacle: poses are not drawn into the unknown, nor driven out of it.
constexpr double kUnknownLikelihood = 0.3;

using Points = std::vector<Eigen::Vector2d>;

/// Where beams end, from where the laser was at the stamp; one of those that fall into one cell, so
/// that near walls do not count more than far ones.
Points endsOf(const LaserScan& scan, double range_m, double resolution_m) {
  Points ends;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    if (!scan.isHit(range) || range > range_m) continue;
    const double bearing = scan.bearing(i);
    Eigen::Vector2d end = range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    if (!scan.T_stamp_beam.empty()) end = scan.T_stamp_beam[i] * end;
    if (ends.empty() || (end - ends.back()).norm() >= resolution_m) ends.push_back(end);
  }
  return ends;
}

/// Log-likelihood of hits by their distance from obstacles of the map.
class HitModel {
 public:
  explicit HitModel(const OccupancyField& field) : field_(field) {
    const double farthest = logLikelihood(field.farthest());
    const auto at_farthest = static_cast<float>(field.farthest());
    by_cell_.reserve(field.distances().size());
    for (const float distance : field.distances()) {
      double value = farthest;
      if (std::isnan(distance)) value = std::log(kUnknownLikelihood);
      if (distance < at_farthest) value = logLikelihood(static_cast<double>(distance));
      by_cell_.push_back(static_cast<float>(value));
    }
  }

  double coarse(const Points& rotated, const Eigen::Vector2d& origin) const {
    float sum = 0.0F;
    for (const Eigen::Vector2d& point : rotated) {
      const int cell = field_.cellAt(origin + point);
      if (cell >= 0) sum += by_cell_[std::size_t(cell)];
    }
    return static_cast<double>(sum);
  }

  double fine(const Points& points, const Pose2& T_map_laser) const {
    const Eigen::Matrix2d R = T_map_laser.rotation();
    double sum = 0.0;
    for (const Eigen::Vector2d& point : points) {
      const Eigen::Vector2d place = T_map_laser.position() + R * point;
      sum += field_.knows(place) ? logLikelihood(field_.smoothDistance(place))
                                 : std::log(kUnknownLikelihood);
    }
    return sum;
  }

 private:
  double logLikelihood(double distance_m) const {
    const double cells = distance_m / field_.resolution_m();
    return std::log(kOutlierShare + (1.0 - kOutlierShare) * std::exp(-0.5 * cells * cells));
  }

  const OccupancyField& field_;
  std::vector<float> by_cell_;
};

/// The best pose on a lattice around a guess, in steps of a cell where beams end.
Pose2 bestOnLattice(const HitModel& model, const Points& points, const Pose2& guess,
                    const ScanMatcherConfig& config, double step_m) {
  double reach = step_m;
  for (const Eigen::Vector2d& point : points) reach = std::max(reach, point.norm());
  const int turns = static_cast<int>(std::ceil(config.search_heading_rad * reach / step_m));
  const int steps = static_cast<int>(std::ceil(config.search_radius_m / step_m));
  Pose2 best = guess;
  double best_score = -std::numeric_limits<double>::infinity();
  Points rotated(points.size());
  for (int k = -turns; k <= turns; ++k) {
    const Pose2 turned{0.0, 0.0, guess.yaw_rad + k * step_m / reach};
    const Eigen::Matrix2d R = turned.rotation();
    std::transform(points.begin(), points.end(), rotated.begin(),
                   [&](const Eigen::Vector2d& point) { return R * point; });
    for (int j = -steps; j <= steps; ++j) {
      for (int i = -steps; i <= steps; ++i) {
        const Eigen::Vector2d origin = guess.position() + step_m * Eigen::Vector2d(i, j);
        const double score = model.coarse(rotated, origin);
        if (score <= best_score) continue;
        best_score = score;
        best = {origin.x(), origin.y(), turned.yaw_rad};
      }
    }
  }
  return best;
}

/// Second differences of the log-likelihood around a pose, by steps in x, y, yaw.
Eigen::Matrix3d curvature(const HitModel& model, const Points& points, const Pose2& at,
                          const Eigen::Vector3d& steps) {
  const auto value = [&](const Eigen::Vector3d& off) {
    return model.fine(points, Pose2::fromVector(at.vector() + off));
  };
  Eigen::Matrix3d curvature;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      const Eigen::Vector3d a = steps[i] * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d b = steps[j] * Eigen::Vector3d::Unit(j);
      curvature(i, j) = curvature(j, i) =
          (value(a + b) - value(a - b) - value(b - a) + value(-a - b)) /
          (4.0 * steps[i] * steps[j]);
    }
  }
  return curvature;
}

/// Climbs from a point of the lattice by ever smaller steps along the three axes, as far as its
/// neighbours: along a corridor it could go on for ever.
Pose2 climb(const HitModel& model, const Points& points, Pose2 pose, Eigen::Vector3d steps) {
  constexpr int kHalvings = 5;
  const Eigen::Vector3d start = pose.vector(), reach = 2.0 * steps;
  double score = model.fine(points, pose);
  for (int halving = 0; halving < kHalvings; ++halving, steps *= 0.5) {
    for (bool climbs = true; climbs;) {
      climbs = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
          const Pose2 next =
              Pose2::fromVector(pose.vector() + sign * steps[axis] * Eigen::Vector3d::Unit(axis));
          const Eigen::Vector3d off = next.vector() - start;
          const Eigen::Vector3d wrapped(off.x(), off.y(), wrapAngle(off.z()));
          if ((wrapped.cwiseAbs().array() > reach.array()).any()) continue;
          const double next_score = model.fine(points, next);
          if (next_score <= score) continue;
          score = next_score;
          pose = next;
          climbs = true;
        }
      }
    }
  }
  return pose;
}

/// Inverse of the information in the curvature, no direction being less certain than the window
/// makes it (a corridor tells nothing along itself).
Eigen::Matrix3d covarianceOf(const Eigen::Matrix3d& curvature, double variance_factor,
                             const ScanMatcherConfig& config) {
  // In units of the window the three axes compare.
  const Eigen::Vector3d window(config.search_radius_m, config.search_radius_m,
                               config.search_heading_rad);
  const Eigen::Matrix3d scaled = window.asDiagonal() * (-curvature) * window.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scaled);
  constexpr double kUniformInformation = 3.0;  // of what lies anywhere between -1 and 1
  const Eigen::Vector3d variances =
      (axes.eigenvalues().cwiseMax(0.0) / variance_factor).array() + kUniformInformation;
  const Eigen::Matrix3d covariance =
      axes.eigenvectors() * variances.cwiseInverse().asDiagonal() * axes.eigenvectors().transpose();
  return window.asDiagonal() * covariance * window.asDiagonal();
}

/// What no number of beams makes better: where in its cells a wall lies is common to all of them.
Eigen::Matrix3d roundingCovariance(const Points& points, double resolution_m) {
  double square_reach = resolution_m * resolution_m;
  for (const Eigen::Vector2d& point : points) square_reach += point.squaredNorm();
  square_reach /= static_cast<double>(points.size());
  const double variance = resolution_m * resolution_m / 12.0;
  return Eigen::Vector3d(variance, variance, variance / square_reach).asDiagonal();
}

/// What hits say of a match.
struct Fit {
  int known = 0;
  double score = 0.0;
  double variance_cells = 0.0;  ///< mean square distance from obstacles of those that hit them
};

Fit fitOf(const OccupancyField& field, const Points& points, const Pose2& T_map_laser) {
  Fit fit;
  int on_obstacles = 0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d place = T_map_laser * point;
    if (!field.knows(place)) continue;
    ++fit.known;
    const double cells = field.smoothDistance(place) / field.resolution_m();
    if (cells > 1.5) continue;
    ++on_obstacles;
    fit.variance_cells += cells * cells;
  }
  if (fit.known > 0) fit.score = static_cast<double>(on_obstacles) / fit.known;
  if (on_obstacles > 0) fit.variance_cells /= on_obstacles;
  return fit;
}

ScanMatch refused(const std::string& reason) {
  ScanMatch match;
  match.reason = reason;
  return match;
}

}  // namespace

void ScanMatcherConfig::describe(ConfigSchema& schema) {
  schema.number("search_radius_m", search_radius_m, Range{0.0, 10.0, true},
                "around the guess, in which poses are tried");
  schema.number("search_heading_rad", search_heading_rad, Range{0.0, kPi, true},
                "to both sides of the guess");
  schema.number("range_m", range_m, Range::positive(), "up to which beams are used");
  schema.integer("min_known_beams", min_known_beams, Range::between(3.0, 1e6),
                 "beams that must end where the map knows something, else nothing is said");
  schema.number("min_score", min_score, Range::between(0.0, 1.0),
                "share of these that must end on obstacles of the map, else nothing matched");
}

ScanMatcher::ScanMatcher(const ScanMatcherConfig& config) : config_(config) {
  ConfigSchema schema;
  config_.describe(schema);
  const std::vector<std::string> problems = rangeProblems(schema);
  if (!problems.empty()) throw ConfigError(problems);
}

ScanMatch ScanMatcher::match(const HybridMap& map, const LaserScan& scan,
                             const Pose2& guess) const {
  if (auto problem = scanProblem(scan)) return refused(*problem);
  if (!isPlace(guess.position()) || !std::isfinite(guess.yaw_rad)) {
    return refused("the guess is not finite");
  }
  const double resolution = map.resolution_m();
  const OccupancyField field(map, guess.position(), config_.range_m + config_.search_radius_m,
                             resolution);
  if (!field.hasObstacles()) return refused("the map knows no obstacles around the guess");
  const Points points = endsOf(scan, config_.range_m, resolution);
  if (points.empty()) return refused("no beam of the scan ends within range_m");
  const HitModel model(field);
  const double half_cell = 0.5 * resolution;
  const Eigen::Vector3d steps(half_cell, half_cell, half_cell / config_.range_m);
  ScanMatch match;
  match.T_map_laser =
      climb(model, points, bestOnLattice(model, points, guess, config_, resolution), steps);
  const Fit fit = fitOf(field, points, match.T_map_laser);
  match.score = fit.score;
  match.known_beams = fit.known;
  // The model has a deviation of one cell; what is left over tells the true one, though never less
  // than that of a place that may be anywhere in a cell.
  const double variance_factor = std::max(fit.variance_cells, 1.0 / 12.0);
  match.covariance = covarianceOf(curvature(model, points, match.T_map_laser, 2.0 * steps),
                                  variance_factor, config_) +
                     roundingCovariance(points, resolution);
  if (match.known_beams < config_.min_known_beams) {
    match.reason = "only " + std::to_string(match.known_beams) +
                   " beams end where the map knows something, of " +
                   std::to_string(config_.min_known_beams) + " that are needed";
  } else if (match.score < config_.min_score) {
    match.reason = "of the beams that end where the map knows something only " +
                   std::to_string(static_cast<int>(std::lround(100.0 * match.score))) +
                   " % end on obstacles";
  } else {
    match.matched = true;
  }
  return match;
}

}  // namespace hymm::core
