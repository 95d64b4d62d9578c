#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "relocaliser/relocaliser.h"
#include "simulation/simulation.h"

namespace hymm::test {

/// One scan of a relocalisation beside the truth.
struct RelocalisationScan {
  double error_m = 0.0;
  double heading_error_rad = 0.0;
  double cekf_error_m = 0.0;  ///< of the CEKF, which goes on by itself
  core::RelocaliserOutcome outcome;
};

struct RelocalisationRun {
  double prior_error_m = 0.0;      ///< of the pose that the relocaliser begins with
  double prior_deviation_m = 0.0;  ///< that it is told, largest axis
  std::size_t map_landmarks = 0;
  std::vector<RelocalisationScan> scans;  ///< from T0 on
  std::optional<std::size_t> accepted;    ///< index of the first scan that converged
  std::string problem;                    ///< if there is no map to begin with
};

/// The world `loop`, driven round once by the CEKF, which then stops: the relocaliser has to find
/// the vehicle in the avenue where the drive began.
class LoopRelocalisation {
 public:
  explicit LoopRelocalisation(std::uint64_t seed) : seed_(seed) {
    config_.world.name = "loop";
    config_.drive.laps = 2;
    config_.laser.enabled = false;
    config_.gps.enabled = false;
    config_.detections.enabled = true;
    config_.detections.range_max_m = 25.0;
    config_.detections.detection_probability = 0.9;
    config_.detections.false_detections = 1.0;
  }

  core::RelocaliserConfig relocaliser() const {
    core::RelocaliserConfig config;
    config.range_m = config_.detections.range_max_m;
    config.expected_range_m = 20.0;
    return config;
  }

  /// Called after each scan.
  using Watch = std::function<void(const core::Relocaliser&, const core::ObservationSet&,
                                   const core::Pose2& truth, std::size_t scan)>;

  RelocalisationRun run(const core::RelocaliserConfig& config, std::size_t scans,
                        const Watch& watch = nullptr) {
    const core::VehicleConfig vehicle = core::simulatedCar();
    core::Simulation simulation(config_, vehicle, seed_);
    core::CekfSlamConfig slam_config;
    slam_config.observation_input = "detections";
    core::CekfSlam slam(slam_config, vehicle);
    RelocalisationRun result;
    std::optional<core::Relocaliser> relocaliser;
    double way_m = 0.0;
    core::Pose2 last;
    while (auto simulated = simulation.next()) {
      way_m += (simulated->T_map_base.position() - last.position()).norm();
      last = simulated->T_map_base;
      slam.process(simulated->event);
      if (!relocaliser) {
        if (way_m < kWayAlone_m) continue;
        begin(slam, vehicle, config, last, relocaliser, result);
        if (!relocaliser) return result;
        continue;
      }
      if (const auto* input = std::get_if<core::MotionInput>(&simulated->event)) {
        relocaliser->process(*input);
      } else if (const auto* set = std::get_if<core::ObservationSet>(&simulated->event)) {
        if (way_m < kWayRound_m) continue;
        const auto outcome = relocaliser->process(*set);
        if (!outcome) continue;
        const core::Pose2 error = core::inverse(last) * outcome->T_map_base;
        const double cekf_error_m = (slam.pose().T_map_base.position() - last.position()).norm();
        if (outcome->converged && !result.accepted) result.accepted = result.scans.size();
        if (watch) watch(*relocaliser, *set, last, result.scans.size());
        result.scans.push_back(
            {error.position().norm(), std::abs(error.yaw_rad), cekf_error_m, *outcome});
        if (result.scans.size() >= scans) break;
      }
    }
    return result;
  }

 private:
  static constexpr double kLately_s = 60.0;
  static constexpr double kWayAlone_m = 840.0;  // until here the CEKF meets nothing that it knows
  static constexpr double kWayRound_m = 900.0;  // from here the avenue is in view: T0

  void begin(core::CekfSlam& slam, const core::VehicleConfig& vehicle,
             const core::RelocaliserConfig& config, const core::Pose2& truth,
             std::optional<core::Relocaliser>& relocaliser, RelocalisationRun& result) {
    const core::PoseEstimate pose = slam.pose();
    core::VehicleAmongLandmarks estimate;
    std::vector<int> ids;
    for (const auto& landmark : slam.landmarkMap(0.0).landmarks) {
      // What was seen lately came along with the vehicle.
      if (pose.time_s - landmark.last_seen_s > kLately_s) ids.push_back(landmark.id);
    }
    slam.requestJointLandmarks(ids,
                               [&](core::JointLandmarks joint) { estimate.landmarks = joint; });
    estimate.vehicle = {pose.T_map_base, pose.covariance};
    result.prior_error_m = (pose.T_map_base.position() - truth.position()).norm();
    result.prior_deviation_m = std::sqrt(pose.covariance.diagonal().head<2>().maxCoeff());
    auto map = core::tryMakeLocalMap(estimate, config.range_m + kWayRound_m - kWayAlone_m,
                                     config.local_map, result.problem);
    if (!map) return;
    result.map_landmarks = map->landmarks.size();
    relocaliser.emplace(config, vehicle, slam.calibration(), core::RandomGenerator(seed_));
    relocaliser->begin(std::move(*map), pose.time_s);
  }

  std::uint64_t seed_;
  core::SimulationConfig config_;
};

}  // namespace hymm::test
