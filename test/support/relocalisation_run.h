#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "cekf/cekf_slam.h"
#include "relocaliser/relocaliser.h"
#include "simulation/simulation.h"

namespace hymm::test {

/// One scan of a relocalisation beside the truth.
struct RelocalisationScan {
  double error_m = 0.0;
  double heading_error_rad = 0.0;
  double nees = 0.0;             ///< of the pose found, 3 degrees of freedom
  double cekf_error_m = 0.0;     ///< of the CEKF that goes on by itself
  double resumed_error_m = 0.0;  ///< of the one that waits, and goes on from the place found
  double resumed_nees = 0.0;     ///< of its pose, 3 degrees of freedom
  bool resumed = false;
  core::RelocaliserOutcome outcome;
};

struct RelocalisationRun {
  double prior_error_m = 0.0;      ///< of the pose that the relocaliser begins with
  double prior_deviation_m = 0.0;  ///< that it is told, largest axis
  std::size_t map_landmarks = 0;
  std::vector<RelocalisationScan> scans;  ///< from T0 on
  std::optional<std::size_t> accepted;    ///< index of the first scan that converged
  core::Resumption resumption;            ///< what the CEKF made of it
  double map_error_before_m = 0.0;        ///< root mean square over the landmarks, at T0
  double map_error_after_m = 0.0;         ///< at the end
  double map_error_alone_m = 0.0;         ///< of the CEKF that went on by itself
  std::string problem;                    ///< if there is no map to begin with
};

/// The world `loop`, driven round once by the CEKF, which then waits: the relocaliser has to find
/// the vehicle in the avenue where the drive began, and the CEKF to go on from there.
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
    core::CekfSlam alone(slam_config, vehicle), slam(slam_config, vehicle);
    slam.keepLocalStates(kKept_s);
    RelocalisationRun result;
    std::optional<core::Relocaliser> relocaliser;
    std::vector<core::PlaceAtScan> path;
    double way_m = 0.0, T0_s = 0.0;
    core::Pose2 last;
    while (auto simulated = simulation.next()) {
      way_m += (simulated->T_map_base.position() - last.position()).norm();
      last = simulated->T_map_base;
      alone.process(simulated->event);
      slam.process(simulated->event);
      const auto* set = std::get_if<core::ObservationSet>(&simulated->event);
      if (!relocaliser) {
        if (way_m < kWayAlone_m || set == nullptr) continue;
        T0_s = set->time_s;
        slam.suspend(T0_s);
        result.map_error_before_m = mapError_m(slam, simulation);
        begin(slam, vehicle, config, last, relocaliser, result);
        if (!relocaliser) return result;
        continue;
      }
      if (const auto* input = std::get_if<core::MotionInput>(&simulated->event)) {
        relocaliser->process(*input);
      } else if (set != nullptr) {
        if (way_m < kWayRound_m) continue;
        const auto outcome = relocaliser->process(*set);
        if (!outcome) continue;
        if (watch) watch(*relocaliser, *set, last, result.scans.size());
        if (outcome->held_scans == 0) path.clear();
        path.push_back({set->time_s, outcome->T_map_base});
        if (outcome->converged && !result.accepted) {
          result.accepted = result.scans.size();
          result.resumption = slam.resume(T0_s, path);
        }
        result.scans.push_back(compare(*outcome, last, alone, slam));
        if (result.scans.size() >= scans) break;
      }
    }
    result.map_error_after_m = mapError_m(slam, simulation);
    result.map_error_alone_m = mapError_m(alone, simulation);
    return result;
  }

 private:
  static constexpr double kKept_s = 2.4;
  static constexpr double kWayAlone_m = 870.0;  // until here the CEKF meets nothing that it knows
  static constexpr double kWayRound_m = 900.0;  // from here the avenue is in view: T0

  static RelocalisationScan compare(const core::RelocaliserOutcome& outcome,
                                    const core::Pose2& truth, const core::CekfSlam& alone,
                                    const core::CekfSlam& slam) {
    const core::Pose2 error = core::inverse(truth) * outcome.T_map_base;
    RelocalisationScan scan;
    scan.error_m = error.position().norm();
    scan.heading_error_rad = std::abs(error.yaw_rad);
    Eigen::Vector3d off = outcome.T_map_base.vector() - truth.vector();
    off.z() = core::wrapAngle(off.z());
    scan.nees = off.dot(outcome.covariance.inverse() * off);
    scan.cekf_error_m = (alone.pose().T_map_base.position() - truth.position()).norm();
    const core::PoseEstimate pose = slam.pose();
    Eigen::Vector3d e = pose.T_map_base.vector() - truth.vector();
    e.z() = core::wrapAngle(e.z());
    scan.resumed_error_m = e.head<2>().norm();
    scan.resumed_nees = e.dot(pose.covariance.inverse() * e);
    scan.resumed = !slam.isSuspended();
    scan.outcome = outcome;
    return scan;
  }

  /// Of the landmarks against the true ones that are nearest.
  static double mapError_m(core::CekfSlam& slam, const core::Simulation& simulation) {
    double sum_m2 = 0.0;
    const core::LandmarkMap map = slam.landmarkMap(0.0);
    for (const core::LandmarkEstimate& landmark : map.landmarks) {
      double nearest_m2 = std::numeric_limits<double>::infinity();
      for (const core::TrueLandmark& truth : simulation.landmarks()) {
        nearest_m2 = std::min(nearest_m2, (truth.position - landmark.position).squaredNorm());
      }
      sum_m2 += nearest_m2;
    }
    return std::sqrt(sum_m2 / static_cast<double>(std::max<std::size_t>(1, map.landmarks.size())));
  }

  void begin(core::CekfSlam& slam, const core::VehicleConfig& vehicle,
             const core::RelocaliserConfig& config, const core::Pose2& truth,
             std::optional<core::Relocaliser>& relocaliser, RelocalisationRun& result) {
    std::vector<int> ids;
    for (const auto& landmark : slam.landmarkMap(0.0).landmarks) ids.push_back(landmark.id);
    core::VehicleAmongLandmarks estimate;
    slam.requestVehicleAmongLandmarks(
        ids, [&](const core::VehicleAmongLandmarks& joint) { estimate = joint; });
    const core::PoseEstimate pose = slam.pose();
    result.prior_error_m = (pose.T_map_base.position() - truth.position()).norm();
    result.prior_deviation_m = std::sqrt(pose.covariance.diagonal().head<2>().maxCoeff());
    auto map = core::tryMakeLocalMap(estimate, config.range_m, config.local_map, result.problem);
    if (!map) return;
    result.map_landmarks = map->landmarks.size();
    relocaliser.emplace(config, vehicle, slam.calibration(), core::RandomGenerator(seed_));
    relocaliser->begin(std::move(*map), pose.time_s);
  }

  std::uint64_t seed_;
  core::SimulationConfig config_;
};

}  // namespace hymm::test
