#include "perception/reflector_detector.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

/// How far before the centre of a pole the ranges of its bright beams end.
struct Depth {
  double mean_m;
  double variance;  ///< m^2, from beam to beam
};

/// A beam whose middle meets a circle of radius R anywhere across its width ends R * pi / 4 before
/// the centre on average, with a variance of R^2 (2/3 - pi^2 / 16). Where more is bright than the
/// pole is wide, the other beams have the whole pole in their flank, and end at what shines most of
/// it: the front.
Depth depthOf(double diameter_m, double bright_width_m) {
  const double radius_m = 0.5 * diameter_m;
  const double met = std::min(1.0, diameter_m / bright_width_m);  // share of beams that meet it
  const double across = kPi / 4.0;
  const double variance_met = 2.0 / 3.0 - across * across;
  const double variance_between = (1.0 - met) * (1.0 - across) * (1.0 - across);
  return {radius_m * (met * across + 1.0 - met),
          radius_m * radius_m * met * (variance_met + variance_between)};
}

}  // namespace

ReflectorDetector::ReflectorDetector(const ReflectorConfig& config, const LaserNoise& noise)
    : config_(config), noise_(noise) {}

void ReflectorDetector::detect(const BeamView& beams,
                               std::vector<Observation>& observations) const {
  if (!beams.hasIntensities()) return;
  int start = 0;
  if (beams.fullTurn()) {  // begin where no cluster straddles the seam
    while (start < beams.size() && bright(beams, start)) ++start;
  }
  const int end = start + beams.size();
  for (int index = start; index < end; ++index) {
    if (!bright(beams, index)) continue;
    const Cluster cluster = clusterFrom(beams, index, end);
    index = cluster.last;
    if (isReflector(beams, cluster)) observations.push_back(toObservation(beams, cluster));
  }
}

bool ReflectorDetector::bright(const BeamView& beams, int index) const {
  return beams.contains(index) && beams.intensity(index) >= config_.min_intensity &&
         beams.kind(index) == BeamKind::kHit;
}

ReflectorDetector::Cluster ReflectorDetector::clusterFrom(const BeamView& beams, int first,
                                                          int end) const {
  const double join_limit_m =
      0.5 * config_.diameter_m + 3.0 * std::sqrt(2.0) * noise_.range_noise_m;
  double range_m = beams.range(first);
  Cluster cluster{first, first, range_m, range_m, range_m};
  for (int index = first + 1; index < end && bright(beams, index); ++index) {
    const double next_m = beams.range(index);
    if (std::abs(next_m - range_m) > join_limit_m) break;
    range_m = next_m;
    cluster.last = index;
    cluster.range_sum_m += range_m;
    cluster.nearest_m = std::min(cluster.nearest_m, range_m);
    cluster.farthest_m = std::max(cluster.farthest_m, range_m);
  }
  return cluster;
}

bool ReflectorDetector::isReflector(const BeamView& beams, const Cluster& cluster) const {
  const double width_m = (cluster.hits() - 1) * beams.spacing() * cluster.nearest_m;
  const double depth_m = cluster.farthest_m - cluster.nearest_m;
  return cluster.hits() >= config_.min_beams && std::max(width_m, depth_m) <= config_.max_width_m &&
         cluster.nearest_m + 0.5 * config_.diameter_m <= config_.max_range_m;
}

Observation ReflectorDetector::toObservation(const BeamView& beams, const Cluster& cluster) const {
  const double hits = cluster.hits();
  const Depth depth = depthOf(config_.diameter_m, hits * beams.spacing() * cluster.nearest_m);
  Observation observation;
  observation.type = LandmarkType::kReflector;
  observation.range_m = cluster.range_sum_m / hits + depth.mean_m;
  const double middle = 0.5 * (cluster.first + cluster.last);
  observation.bearing_rad = wrapAngle(beams.bearing(middle));
  observation.after_stamp_s = beams.afterStamp_s(middle);
  observation.covariance.setZero();
  observation.covariance(0, 0) =
      (noise_.range_noise_m * noise_.range_noise_m + depth.variance) / hits +
      std::pow(noise_.range_offset_deviation_m, 2);
  // Each edge of the bright part lies anywhere between two beams; the middle of the two has this
  // variance.
  observation.covariance(1, 1) =
      beams.spacing() * beams.spacing() / 24.0 + std::pow(noise_.bearing_offset_deviation_rad, 2);
  return observation;
}

}  // namespace hymm::core
