#include <algorithm>
#include <cmath>

#include "hybrid_map/log_odds.h"
#include "hybrid_map/scan_matcher.h"

namespace hymm::core {
namespace {

// Along a beam; nearer to each other, samples tell the same again.
constexpr double kFreeSpacing_m = 2.0;

/// Mean and mean square of what the map says at places of one kind.
struct Moments {
  int count = 0;
  double sum = 0.0, squares = 0.0;

  void add(double probability) {
    ++count;
    sum += probability;
    squares += probability * probability;
  }
  double mean() const { return sum / count; }
  double meanSquare() const { return squares / count; }
};

/// Probability of being occupied that the map states.
std::optional<double> occupancyAt(const HybridMap& map, const Eigen::Vector2d& place) {
  const float log_odds = map.occupancyLogOdds(place);
  if (log_odds == 0.0F) return std::nullopt;
  return probabilityOf(static_cast<double>(log_odds));
}

/// The same, the greatest within a cell: beams end within one.
std::optional<double> occupancyAround(const HybridMap& map, const Eigen::Vector2d& place) {
  std::optional<double> greatest;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const auto there = occupancyAt(map, place + map.resolution_m() * Eigen::Vector2d(x, y));
      if (there && (!greatest || *there > *greatest)) greatest = there;
    }
  }
  return greatest;
}

/// Correlation of two equally likely classes with what the map says of each.
double correlationOf(const Moments& hits, const Moments& free) {
  const double mean = 0.5 * (hits.mean() + free.mean());
  const double variance = 0.5 * (hits.meanSquare() + free.meanSquare()) - mean * mean;
  if (variance <= 0.0) return 0.0;
  return 0.5 * (hits.mean() - free.mean()) / std::sqrt(variance);
}

}  // namespace

ScanAgreement ScanMatcher::agreement(const HybridMap& map, const LaserScan& scan,
                                     const Pose2& T_map_laser) const {
  Moments hits, free;
  int beams = 0;
  const double clear_m = 2.0 * map.resolution_m();  // before a beam's end: its own obstacle
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges_m[i]);
    if (!scan.isHit(range) || range > config_.range_m) continue;
    ++beams;
    const Pose2 T_map_beam = scan.poseAtBeam(i, T_map_laser);
    const double bearing = T_map_beam.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    if (const auto there = occupancyAround(map, T_map_beam.position() + range * along)) {
      hits.add(*there);
    }
    for (double at = kFreeSpacing_m; at < range - clear_m; at += kFreeSpacing_m) {
      if (const auto there = occupancyAt(map, T_map_beam.position() + at * along)) {
        free.add(*there);
      }
    }
  }
  ScanAgreement agreement;
  agreement.known_beams = hits.count;
  if (beams > 0) agreement.known_share = static_cast<double>(hits.count) / beams;
  if (hits.count >= config_.min_known_beams && free.count > 0) {
    agreement.correlation = correlationOf(hits, free);
  }
  return agreement;
}

}  // namespace hymm::core
