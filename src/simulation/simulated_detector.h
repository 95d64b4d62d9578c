#pragma once

#include <vector>

#include "simulation/simulated_laser.h"
#include "simulation/truth.h"

namespace hymm::core {

/// A detector that tells the range and bearing of the landmarks in view.
class SimulatedDetector {
 public:
  SimulatedDetector(const SimulatedDetectorConfig& config, RandomGenerator generator);

  /// `nearby` are the landmarks that may be within range.
  ObservationSet detect(const Scene& scene, const std::vector<TrueLandmark>& nearby,
                        const Pose2& T_map_sensor, const Pose2& T_base_sensor, double time_s);

 private:
  bool isInView(const Scene& scene, const TrueLandmark& landmark, const Pose2& T_map_sensor) const;
  Observation measured(const TrueLandmark& landmark, const Pose2& T_map_sensor);
  Observation falseDetection();
  Eigen::Matrix2d covariance() const;

  SimulatedDetectorConfig config_;
  RandomGenerator generator_;
};

}  // namespace hymm::core
