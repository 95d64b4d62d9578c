// Predicted against actual deviations of a vehicle that explores: after part of a simulated drive
// the information map suggests goals; for each of them, and for as many random places at the
// frontier of what is mapped, the same drive goes on there, and the filter that has driven so far
// says how certain it is on the way. One line of CSV a goal; scripts/experiments/exploration makes
// figures of it.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

#include "cekf/cekf_slam.h"
#include "common/error.h"
#include "information_map/information_map.h"
#include "pipeline/suite_config.h"
#include "simulation/simulated_detector.h"
#include "simulation/simulated_vehicle.h"
#include "simulation/simulation.h"

namespace hymm::test {
namespace {

using core::Pose2;
using Eigen::Vector2d;

constexpr double kRange_m = 30.0;  // of the detector, and what the information map counts on
constexpr double kBlockRange_m = 2.0 * kRange_m;
constexpr double kMotion_hz = 40.0;
constexpr int kMotionsPerLook = 8;
constexpr double kNearestGoal_m = 15.0;  // so that the car can turn around before it
constexpr double kArrived_m = 1.5;
constexpr double kTurningRadius_m = 6.0;

core::SimulationConfig driveConfig() {
  core::SimulationConfig config;
  config.world.name = "park";
  config.drive.laps = 2;
  config.laser.enabled = false;
  config.gps.enabled = false;
  config.detections.enabled = true;
  config.detections.range_max_m = kRange_m;
  config.detections.occlusion = false;
  return config;
}

double largestDeviation(const Eigen::Matrix3d& P) {
  const Eigen::Matrix2d position = P.topLeftCorner<2, 2>();
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(position).eigenvalues().maxCoeff());
}

/// The filter and the truth after the first part of a drive. The same each time it is made.
struct Departure {
  Departure(unsigned seed, double duration_s)
      : simulation(driveConfig(), core::simulatedCar(), seed),
        filter(filterConfig(), core::simulatedCar()) {
    while (const auto simulated = simulation.next()) {
      time_s = core::timeOf(simulated->event);
      if (time_s > core::Simulation::kStartTime_s + duration_s) break;
      T_map_base = simulated->T_map_base;
      filter.process(simulated->event);
    }
  }

  static core::CekfSlamConfig filterConfig() {
    core::CekfSlamConfig config;
    config.observation_input = "detections";
    return config;
  }

  core::Simulation simulation;
  core::CekfSlam filter;
  Pose2 T_map_base;  ///< truth
  double time_s = 0.0;
};

/// What became of the vehicle on the way to a goal.
struct Trip {
  double driven_m = 0.0;
  double position_deviation_m = 0.0, heading_deviation_rad = 0.0;  ///< largest, by the filter
  double position_error_m = 0.0, heading_error_rad = 0.0;          ///< largest
  bool arrived = false;
};

/// An arc at the tightest that the car drives with ease, until the target is straight ahead.
std::vector<Vector2d> turnTowards(const Pose2& from, const Vector2d& target) {
  std::vector<Vector2d> points = {from.position()};
  Pose2 pose = from;
  constexpr double kStep_m = 0.25;
  const double side = (inverse(from) * target).y() >= 0.0 ? 1.0 : -1.0;
  const double turn = side * kStep_m / kTurningRadius_m;
  for (int i = 0; i < static_cast<int>(2.0 * core::kPi / std::abs(turn)); ++i) {
    const Vector2d ahead = inverse(pose) * target;
    if (std::abs(std::atan2(ahead.y(), ahead.x())) <= std::abs(turn)) break;
    pose = pose * Pose2{kStep_m, 0.0, turn};
    points.push_back(pose.position());
  }
  return points;
}

/// From the vehicle, heading as it does, along the way; closed behind its back.
core::Route routeAlong(const Pose2& T_map_base, const std::vector<Vector2d>& way) {
  std::size_t first = 0;  // of the way's places that the car can turn to
  while (first + 1 < way.size() &&
         (way[first] - T_map_base.position()).norm() < 2.0 * kTurningRadius_m) {
    ++first;
  }
  std::vector<Vector2d> points = turnTowards(T_map_base, way[first]);
  points.insert(points.end(), way.begin() + std::ptrdiff_t(first), way.end());
  const Vector2d on = (points.back() - points[points.size() - 2]).normalized();
  points.emplace_back(points.back() + 5.0 * on);  // not to turn back before the goal
  points.emplace_back(T_map_base * Vector2d(-1.0, 0.0));
  return core::Route(points);
}

std::vector<core::TrueLandmark> landmarksNear(const core::Simulation& simulation,
                                              const Vector2d& place) {
  std::vector<core::TrueLandmark> nearby;
  for (const core::TrueLandmark& landmark : simulation.landmarks()) {
    if ((landmark.position - place).norm() <= kRange_m) nearby.push_back(landmark);
  }
  return nearby;
}

/// The drive's sensors, with the calibration that was drawn for it.
core::SimulationConfig continuedConfig(const core::Simulation& simulation) {
  core::SimulationConfig config = driveConfig();
  config.motion.draw_calibration = false;
  config.motion.speed_scale = simulation.calibration().speed_scale;
  config.motion.turn_scale = simulation.calibration().turn_scale;
  config.motion.turn_offset = simulation.calibration().turn_offset;
  return config;
}

void note(Trip& trip, const core::PoseEstimate& pose, const Pose2& truth) {
  const auto raise = [](double& largest, double now) { largest = std::max(largest, now); };
  raise(trip.position_deviation_m, largestDeviation(pose.covariance));
  raise(trip.heading_deviation_rad, std::sqrt(pose.covariance(2, 2)));
  raise(trip.position_error_m, (pose.T_map_base.position() - truth.position()).norm());
  raise(trip.heading_error_rad, std::abs(core::wrapAngle(pose.T_map_base.yaw_rad - truth.yaw_rad)));
}

/// Goes on along a way, which is given in the filter's map.
Trip drive(Departure& from, const std::vector<Vector2d>& way_in_estimate, unsigned seed) {
  const core::VehicleConfig car = core::simulatedCar();
  // The car steers by its estimate: what lies before it is before it in truth.
  const Pose2 T_truth_estimate = from.T_map_base * inverse(from.filter.pose().T_map_base);
  std::vector<Vector2d> way;
  for (const Vector2d& place : way_in_estimate) way.push_back(T_truth_estimate * place);
  const core::SimulationConfig config = continuedConfig(from.simulation);
  core::SimulatedVehicle vehicle(car, config.motion, config.drive, routeAlong(from.T_map_base, way),
                                 core::ExplorationConfig{}.speed_mps, core::RandomGenerator(seed));
  core::SimulatedDetector detector(config.detections, core::RandomGenerator(seed + 1));
  const std::vector<core::Solid> nothing;
  const core::RayCaster caster(nothing);
  const core::Scene scene(nothing, caster, {});
  const Pose2 T_base_sensor = car.laser.T_base_sensor();

  Trip trip;
  Vector2d last = from.T_map_base.position();
  const double period_s = 1.0 / kMotion_hz;
  for (int tick = 0; trip.driven_m < 200.0 && !vehicle.isDone(); ++tick) {
    const double time_s = from.time_s + tick * period_s;
    from.filter.process(vehicle.control(time_s, period_s));
    const Pose2 truth = vehicle.T_map_base(time_s);
    trip.driven_m += (truth.position() - last).norm();
    last = truth.position();
    if (tick % kMotionsPerLook != 0) continue;
    const Pose2 T_map_sensor = truth * T_base_sensor;
    const auto outcome = from.filter.process(
        detector.detect(scene, landmarksNear(from.simulation, T_map_sensor.position()),
                        T_map_sensor, T_base_sensor, time_s));
    if (!outcome || !outcome->accepted) continue;
    note(trip, outcome->pose, truth);
    trip.arrived = (truth.position() - way.back()).norm() < kArrived_m;
    if (trip.arrived) break;
  }
  return trip;
}

/// Random places at the edge of what is in range of a landmark, within some distances.
std::vector<core::ExplorationGoal> frontierGoals(const core::LandmarkMap& map, const Pose2& pose,
                                                 std::size_t count, double nearest_m,
                                                 double farthest_m,
                                                 core::RandomGenerator& generator) {
  std::vector<core::ExplorationGoal> goals;
  for (int tries = 0; goals.size() < count && tries < 100000; ++tries) {
    const auto& from = map.landmarks[generator() % map.landmarks.size()];
    const double angle = core::sampleUniform(generator, -core::kPi, core::kPi);
    const Vector2d place = from.position + kRange_m * Vector2d(std::cos(angle), std::sin(angle));
    const double way_m = (place - pose.position()).norm();
    if (way_m < nearest_m || way_m > farthest_m) continue;
    const bool is_frontier = std::none_of(
        map.landmarks.begin(), map.landmarks.end(),
        [&](const auto& landmark) { return (landmark.position - place).norm() < kRange_m - 1e-6; });
    if (!is_frontier) continue;
    core::ExplorationGoal goal;
    goal.way = {pose.position(), place};
    goal.way_m = way_m;
    goals.push_back(goal);
  }
  return goals;
}

/// The first `count` of the suggested goals that are far enough.
std::vector<core::ExplorationGoal> suggestedGoals(const core::ExplorationAnswer& answer,
                                                  std::size_t count) {
  std::vector<core::ExplorationGoal> goals;
  for (const core::ExplorationGoal& goal : answer.goals) {
    if (goals.size() < count && goal.way_m >= kNearestGoal_m) goals.push_back(goal);
  }
  return goals;
}

void report(const char* kind, unsigned seed, double departure_s, double deviation_then_m,
            const core::ExplorationGoal& goal, const Trip& trip) {
  std::printf("%s,%u,%.1f,%.4f,%.2f,%.4f,%.5f,%.2f,%.4f,%.5f,%.4f,%.5f,%d\n", kind, seed,
              departure_s, deviation_then_m, goal.way_m, goal.position_deviation_m,
              goal.heading_deviation_rad, trip.driven_m, trip.position_deviation_m,
              trip.heading_deviation_rad, trip.position_error_m, trip.heading_error_rad,
              trip.arrived ? 1 : 0);
}

void run(unsigned seed, std::size_t goals_each, const core::InformationMapConfig& config) {
  for (const double departure_s : {20.0, 40.0, 90.0, 150.0}) {
    Departure departure(seed, departure_s);
    const core::LandmarkMap map = departure.filter.landmarkMap(kBlockRange_m);
    const core::PoseEstimate pose = departure.filter.pose();
    core::InformationMap information(config, core::simulatedCar());
    information.apply(map, pose.T_map_base);
    core::ExplorationRequest request;
    request.T_map_base = pose.T_map_base;
    request.covariance = pose.covariance;
    const core::ExplorationAnswer answer = information.suggestExploration(request);
    const auto suggested = suggestedGoals(answer, goals_each);
    if (suggested.empty()) continue;
    const auto [nearest, farthest] =
        std::minmax_element(suggested.begin(), suggested.end(),
                            [](const auto& a, const auto& b) { return a.way_m < b.way_m; });
    core::RandomGenerator generator(seed);
    const auto frontier = frontierGoals(map, pose.T_map_base, suggested.size(), nearest->way_m,
                                        farthest->way_m, generator);
    const double now_m = largestDeviation(pose.covariance);
    unsigned trips = 0;
    for (const core::ExplorationGoal& goal : suggested) {
      Departure from(seed, departure_s);
      report("suggested", seed, departure_s, now_m, goal,
             drive(from, goal.way, 1000 * seed + ++trips));
    }
    for (const core::ExplorationGoal& goal : frontier) {
      Departure from(seed, departure_s);
      report("frontier", seed, departure_s, now_m, goal,
             drive(from, goal.way, 1000 * seed + ++trips));
    }
  }
}

}  // namespace
}  // namespace hymm::test

int main(int argc, char** argv) {
  if (argc != 4 || std::atoi(argv[1]) < 0 || std::atoi(argv[2]) < 1 || !(std::atof(argv[3]) > 0)) {
    std::fputs("Usage: exploration SEED GOALS POSITION_LIMIT_M\n", stderr);
    return 2;
  }
  hymm::core::InformationMapConfig config;
  config.exploration.max_position_deviation_m = std::atof(argv[3]);
  config.information.sensor.range_m = 30.0;
  config.exploration.max_suggestions = 1000;
  // The set to stay in is where one look tells as much as the limit asks for.
  config.level_sets.values =
      std::to_string(1.0 / std::pow(config.exploration.max_position_deviation_m, 2));
  std::puts(
      "kind,seed,departure_s,deviation_then_m,way_m,predicted_position_m,predicted_heading_rad,"
      "driven_m,position_deviation_m,heading_deviation_rad,position_error_m,heading_error_rad,"
      "arrived");
  hymm::test::run(static_cast<unsigned>(std::atoi(argv[1])),
                  static_cast<std::size_t>(std::atoi(argv[2])), config);
  return 0;
}
