#include "hybrid_map/traffic_counter.h"

#include <algorithm>
#include <cmath>

#include "hybrid_map/log_odds.h"

namespace hymm::core {

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
                               std::vector<std::string>& problems)
    : config_(config), free_log_odds_(static_cast<float>(logOddsOf(config.free_probability))) {
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

/// A hit beside something that stands, or beside the unknown behind it, is most likely that: the
/// hit's cell may be off by one, and the map's as well.
bool TrafficCounter::isCertainlyFree(const Eigen::Vector2d& place, double resolution_m,
                                     const Occupancy& occupancy) const {
  if (!(occupancy(place) < free_log_odds_)) return false;
  for (const double x : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
    for (const double y : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
      if (occupancy(place + resolution_m * Eigen::Vector2d(x, y)) >= 0.0F) return false;
    }
  }
  return true;
}

std::size_t TrafficCounter::look(const LaserScan& scan, const Pose2& T_map_laser, double range_m,
                                 double resolution_m, const Occupancy& occupancy,
                                 const Taker& take) {
  std::size_t moved = 0;
  const bool runs_back = period_start_s_ && scan.time_s < *period_start_s_;
  if (!period_start_s_ || runs_back || scan.time_s >= *period_start_s_ + config_.period_s) {
    if (period_start_s_ && !runs_back) moved = handOut(scan.time_s, take);
    squares_.clear();
    period_start_s_ = scan.time_s;
    watch(scan, T_map_laser, range_m);
  }
  std::vector<Eigen::Vector2d> run;  // ends of beams side by side that met something that moves
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const bool is_hit = range >= scan.range_min_m && range < scan.range_max_m && range <= range_m;
    const double bearing = scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    const Eigen::Vector2d end = T_map_laser * ((is_hit ? range : 0.0) * along);
    const bool moves = is_hit && isCertainlyFree(end, resolution_m, occupancy);
    const bool continues = !run.empty() && (end - run.back()).norm() <= config_.square_m;
    if (!moves || !continues) finishRun(run);
    if (moves) run.push_back(end);
  }
  finishRun(run);
  return moved;
}

/// What is slimmer than an object of interest is more likely a post that no beam met before.
void TrafficCounter::finishRun(std::vector<Eigen::Vector2d>& run) {
  if (!run.empty() && (run.back() - run.front()).norm() >= config_.min_width_m) {
    for (const Eigen::Vector2d& end : run) squares_[squareOf(end)] = true;
  }
  run.clear();
}

/// All squares that beams pass are watched.
void TrafficCounter::watch(const LaserScan& scan, const Pose2& T_map_laser, double range_m) {
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    if (!(range >= scan.range_min_m)) continue;
    const double bearing = scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    const double end = std::min({range, range_m, scan.range_max_m});
    for (double at = 0.0; at < end; at += config_.square_m) {
      squares_.emplace(squareOf(T_map_laser * (at * along)), false);
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
