#include "simulation/simulated_detector.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

SimulatedDetector::SimulatedDetector(const SimulatedDetectorConfig& config,
                                     RandomGenerator generator)
    : config_(config), generator_(generator) {}

ObservationSet SimulatedDetector::detect(const Scene& scene,
                                         const std::vector<TrueLandmark>& nearby,
                                         const Pose2& T_map_sensor, const Pose2& T_base_sensor,
                                         double time_s) {
  ObservationSet set{time_s, T_base_sensor, {}};
  for (const TrueLandmark& landmark : nearby) {
    if (!isInView(scene, landmark, T_map_sensor)) continue;
    if (sampleUniform(generator_, 0.0, 1.0) >= config_.detection_probability) continue;
    set.observations.push_back(measured(landmark, T_map_sensor));
  }
  if (config_.false_detections > 0.0) {
    const int count = std::poisson_distribution<int>(config_.false_detections)(generator_);
    for (int i = 0; i < count; ++i) set.observations.push_back(falseDetection());
  }
  std::sort(set.observations.begin(), set.observations.end(),
            [](const auto& a, const auto& b) { return a.bearing_rad < b.bearing_rad; });
  return set;
}

bool SimulatedDetector::isInView(const Scene& scene, const TrueLandmark& landmark,
                                 const Pose2& T_map_sensor) const {
  const Eigen::Vector2d p = inverse(T_map_sensor) * landmark.position;
  const double range = p.norm(), bearing = std::atan2(p.y(), p.x());
  if (range > config_.range_max_m || range <= landmark.diameter_m / 2.0) return false;
  if (std::abs(bearing) > config_.field_of_view_rad / 2.0) return false;
  if (!config_.occlusion) return true;
  const auto hit = scene.cast(BeamPlane(T_map_sensor).beam(bearing), range);
  return hit && hit->solid->landmark == landmark.id;
}

Observation SimulatedDetector::measured(const TrueLandmark& landmark, const Pose2& T_map_sensor) {
  const Eigen::Vector2d p = inverse(T_map_sensor) * landmark.position;
  Observation observation;
  observation.range_m = p.norm() + sampleNormal(generator_, config_.range_deviation_m);
  observation.bearing_rad =
      wrapAngle(std::atan2(p.y(), p.x()) + sampleNormal(generator_, config_.bearing_deviation_rad));
  observation.covariance = covariance();
  observation.type = landmark.type;
  if (config_.diameter_deviation_m > 0.0) {
    observation.diameter_m =
        landmark.diameter_m + sampleNormal(generator_, config_.diameter_deviation_m);
    observation.diameter_variance = config_.diameter_deviation_m * config_.diameter_deviation_m;
  }
  if (config_.identities) observation.identity = landmark.id;
  return observation;
}

Observation SimulatedDetector::falseDetection() {
  const double half_view = std::min(config_.field_of_view_rad / 2.0, kPi);
  Observation observation;
  // Even over the area that is in view.
  observation.range_m = config_.range_max_m * std::sqrt(sampleUniform(generator_, 0.001, 1.0));
  observation.bearing_rad = sampleUniform(generator_, -half_view, half_view);
  observation.covariance = covariance();
  observation.type = LandmarkType::kTrunk;
  if (config_.diameter_deviation_m > 0.0) {
    observation.diameter_m = sampleUniform(generator_, 0.05, 1.0);
    observation.diameter_variance = config_.diameter_deviation_m * config_.diameter_deviation_m;
  }
  return observation;
}

Eigen::Matrix2d SimulatedDetector::covariance() const {
  return Eigen::Vector2d(config_.range_deviation_m, config_.bearing_deviation_rad)
      .cwiseAbs2()
      .asDiagonal();
}

}  // namespace hymm::core
