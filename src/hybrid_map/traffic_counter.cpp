#include "hybrid_map/traffic_counter.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "hybrid_map/log_odds.h"
#include "hybrid_map/written_beam.h"

namespace hymm::core {
namespace {

// Cells that must be free to each side of a hit: one for the pose, which may be off by about a
// cell (max_pose_deviation_m), and one because the map's cells lie otherwise than these.
constexpr int kMargin = 2;

// Cells across the block in which the map's cell of a place may lie, and across the block that is
// looked at around a hit.
constexpr int kAcrossPlace = 3, kAcrossAll = kAcrossPlace + 2 * kMargin;

// What is slower stands: of people who walk, the slowest.
constexpr double kSlowest_mps = 0.5;

// Of a box, and of all that is round, one face at least that a laser sees is turned away from it by
// at most 45 degrees: there ranges differ from beam to beam by no more than beams lie apart.
constexpr double kSteepestRise = 1.0;

}  // namespace

void TrafficConfig::describe(ConfigSchema& schema) {
  schema.text("layer", layer,
              "a rate layer in which moving objects are counted that the occupancy reveals; empty "
              "for none");
  schema.text("weather", weather, "at present, if the layer tells weathers apart");
  schema.number("free_probability", free_probability, Range::between(0.04, 0.4),
                "of being occupied, below which a place is certainly free");
  schema.number("min_width_m", min_width_m, Range{0.0, 10.0, true},
                "of a moving object, as far as it is seen");
  schema.number("square_m", square_m, Range::between(0.2, 10.0),
                "side of the squares in which moving objects are counted");
  schema.number("period_s", period_s, Range::between(0.1, 60.0),
                "in which what moves in a square counts once");
}

TrafficCounter::TrafficCounter(const TrafficConfig& config, const LayerSet& layers,
                               double resolution_m, std::vector<std::string>& problems)
    : config_(config),
      cell_m_(resolution_m),
      free_log_odds_(static_cast<float>(logOddsOf(config.free_probability))) {
  if (config.layer.empty()) return;
  const int layer = layers.find(config.layer);
  if (layer < 0) {
    problems.push_back("traffic.layer: there is no layer '" + config.layer + "'.");
    return;
  }
  LayerSample sample;
  sample.exposure_s = 1.0;
  sample.label = config.weather;
  if (const auto problem = layers.model(layer).problemWith(sample)) {
    problems.push_back("traffic.layer: '" + config.layer + "' cannot count: " + *problem + ".");
    return;
  }
  layer_ = layer;
}

TrafficCounter::Square TrafficCounter::squareOf(const Eigen::Vector2d& place) const {
  const Eigen::Array2d square = (place / config_.square_m).array().floor();
  return {static_cast<int>(square.x()), static_cast<int>(square.y())};
}

TrafficCounter::Cell TrafficCounter::cellOf(const Eigen::Vector2d& place) const {
  const Eigen::Array2d cell = (place / cell_m_).array().floor();
  return {static_cast<int>(cell.x()), static_cast<int>(cell.y())};
}

/// What something that moves takes at most to leave so many cells in a row.
double TrafficCounter::timeToLeave_s(int cells) const { return cells * cell_m_ / kSlowest_mps; }

/// Whether nothing was met there before a time, but something since. Cells beside count as there:
/// the map's cells lie otherwise.
bool TrafficCounter::wasFreeAt(const Eigen::Vector2d& place, double time_s) const {
  if (entered_.empty()) return false;
  const Cell cell = cellOf(place);
  bool is_entered = false;
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      const auto entered = entered_.find({cell.first + x, cell.second + y});
      if (entered == entered_.end()) continue;
      if (entered->second < time_s) return false;
      is_entered = true;
    }
  }
  return is_entered;
}

void TrafficCounter::forgetEntered(double time_s) {
  for (auto cell = entered_.begin(); cell != entered_.end();) {
    const bool is_over = time_s < cell->second || time_s > cell->second + timeToLeave_s(kAcrossAll);
    cell = is_over ? entered_.erase(cell) : std::next(cell);
  }
}

/// A hit beside something that stands, or beside the unknown behind it, is most likely that: the
/// hit's cell may be off by one, and the map's as well.
bool TrafficCounter::isCertainlyFree(const Eigen::Vector2d& place, double time_s,
                                     const Occupancy& occupancy) const {
  if (!(occupancy(place) < free_log_odds_) &&
      !wasFreeAt(place, time_s - timeToLeave_s(kAcrossPlace))) {
    return false;
  }
  for (int x = -kMargin; x <= kMargin; ++x) {
    for (int y = -kMargin; y <= kMargin; ++y) {
      const Eigen::Vector2d beside = place + cell_m_ * Eigen::Vector2d(x, y);
      if (occupancy(beside) >= 0.0F && !wasFreeAt(beside, time_s - timeToLeave_s(kAcrossAll))) {
        return false;
      }
    }
  }
  return true;
}

std::size_t TrafficCounter::look(const LaserScan& scan, const Pose2& T_map_laser,
                                 const OccupancyConfig& written, const Occupancy& occupancy,
                                 const Taker& take) {
  std::size_t moved = 0;
  const bool runs_back = period_start_s_ && scan.time_s < *period_start_s_;
  if (!period_start_s_ || runs_back || scan.time_s >= *period_start_s_ + config_.period_s) {
    if (period_start_s_ && !runs_back) moved = handOut(scan.time_s, take);
    squares_.clear();
    period_start_s_ = scan.time_s;
    watch(scan, T_map_laser, written);
  }
  forgetEntered(scan.time_s);
  Run run;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const bool is_hit = scan.isHit(range) && range <= written.range_m;
    const double bearing = scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    const Pose2 T_map_beam = scan.poseAtBeam(i, T_map_laser);
    const Eigen::Vector2d end = T_map_beam * ((is_hit ? range : 0.0) * along);
    const bool moves = is_hit && isCertainlyFree(end, scan.time_s, occupancy);
    const bool continues = !run.ends.empty() && (end - run.ends.back()).norm() <= config_.square_m;
    if (!moves || !continues) finish(run, scan.time_s);
    if (moves) extend(run, end, range, std::abs(scan.angle_increment_rad));
  }
  finish(run, scan.time_s);
  return moved;
}

void TrafficCounter::extend(Run& run, const Eigen::Vector2d& end, double range_m,
                            double spacing_rad) {
  const double apart_m = std::min(range_m, run.last_range_m) * spacing_rad;
  const double rise_m = std::abs(range_m - run.last_range_m);
  if (!run.ends.empty() && rise_m <= kSteepestRise * apart_m) run.has_steep_face = true;
  run.ends.push_back(end);
  run.last_range_m = range_m;
}

/// What is slimmer than an object of interest is more likely a post that no beam met before.
void TrafficCounter::finish(Run& run, double time_s) {
  for (const Eigen::Vector2d& end : run.ends) entered_.try_emplace(cellOf(end), time_s);
  const bool is_wide =
      !run.ends.empty() && (run.ends.back() - run.ends.front()).norm() >= config_.min_width_m;
  if (is_wide && run.has_steep_face) {
    for (const Eigen::Vector2d& end : run.ends) squares_[squareOf(end)] = true;
  }
  run = {};
}

/// All squares are watched that beams show to be free: where nothing is known nothing is counted.
void TrafficCounter::watch(const LaserScan& scan, const Pose2& T_map_laser,
                           const OccupancyConfig& written) {
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const std::optional<WrittenBeam> beam = writtenBeam(scan, i, written);
    if (!beam) continue;
    const double bearing = scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    const Pose2 T_map_beam = scan.poseAtBeam(i, T_map_laser);
    for (double at = 0.0; at < beam->length_m; at += config_.square_m) {
      squares_.emplace(squareOf(T_map_beam * (at * along)), false);
    }
  }
}

std::size_t TrafficCounter::handOut(double time_s, const Taker& take) {
  constexpr double kMostPeriods = 2.0;  // in a gap between scans nothing is watched
  LayerSample sample;
  sample.time_s = time_s;
  sample.exposure_s = std::min(time_s - *period_start_s_, kMostPeriods * config_.period_s);
  sample.label = config_.weather;
  std::size_t moved = 0;
  for (const auto& [square, is_moved] : squares_) {
    sample.value = is_moved ? 1.0 : 0.0;
    moved += is_moved ? 1 : 0;
    take(config_.square_m * Eigen::Vector2d(square.first + 0.5, square.second + 0.5), sample);
  }
  return moved;
}

}  // namespace hymm::core
