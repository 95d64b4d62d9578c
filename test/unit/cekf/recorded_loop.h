#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "support/loop_drive.h"

namespace hymm::core {

inline constexpr double kRing_s = 6.0;  // 12 scans
inline constexpr std::uint64_t kSeed = 5;

/// A drive as it was recorded.
struct Recording {
  std::vector<SensorEvent> events;
  std::vector<PlaceAtScan> truth;  ///< at the scans
};

inline Recording record(int scans, bool identities = false) {
  test::LoopDrive drive(kSeed, identities);
  Recording recording;
  for (int i = 0; i < scans; ++i) {
    const auto events = drive.next();
    recording.events.insert(recording.events.end(), events.begin(), events.end());
    recording.truth.push_back({drive.time_s(), drive.truth()});
  }
  return recording;
}

inline CekfSlamConfig loopConfig() {
  CekfSlamConfig config;
  config.motion_input = "odom";
  config.active_area.cell_m = 15.0;
  return config;
}

inline CekfSlam newSlam(double kept_s = kRing_s, const CekfSlamConfig& config = loopConfig()) {
  CekfSlam slam(config, VehicleConfig{});
  slam.keepLocalStates(kept_s);
  return slam;
}

inline void feed(CekfSlam& slam, const Recording& recording, double from_s, double to_s) {
  for (const SensorEvent& event : recording.events) {
    if (timeOf(event) > from_s && timeOf(event) <= to_s) slam.process(event);
  }
}

/// Vehicle and all landmarks as one Gaussian.
struct Joint {
  std::vector<int> ids;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

inline Joint jointOf(CekfSlam& slam) {
  std::vector<int> ids;
  for (const auto& landmark : slam.landmarkMap(0.0).landmarks) ids.push_back(landmark.id);
  Joint joint;
  EXPECT_TRUE(slam.requestVehicleAmongLandmarks(ids, [&](const VehicleAmongLandmarks& estimate) {
    const Eigen::Index n = estimate.landmarks.mean.size();
    joint.ids = ids;
    joint.mean.resize(3 + n);
    joint.mean << estimate.vehicle.mean.vector(), estimate.landmarks.mean;
    joint.covariance.resize(3 + n, 3 + n);
    joint.covariance << estimate.vehicle.covariance, estimate.cross_covariance,
        estimate.cross_covariance.transpose(), estimate.landmarks.covariance;
  }));
  return joint;
}

/// Largest difference in units of the first one's deviations.
inline double difference(const Joint& a, const Joint& b) {
  if (a.ids != b.ids) return std::numeric_limits<double>::infinity();
  const Eigen::ArrayXd sigma = a.covariance.diagonal().cwiseSqrt();
  const Eigen::ArrayXXd units = (sigma.matrix() * sigma.matrix().transpose()).array();
  return std::max(((a.mean - b.mean).array() / sigma).abs().maxCoeff(),
                  ((a.covariance - b.covariance).array() / units).abs().maxCoeff());
}

inline constexpr double kEnd_s = 90.0, kT0_s = 76.0;  // the loop closes from 80 s on

}  // namespace hymm::core
