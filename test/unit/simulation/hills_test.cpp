#include <cmath>

#include <gtest/gtest.h>

#include "simulation/beam_plane.h"
#include "simulation/simulated_laser.h"
#include "simulation/simulation.h"
#include "simulation/terrain.h"

namespace hymm::core {
namespace {

Terrain twoHills() {
  return Terrain({{{10.0, 5.0}, 2.0, 12.0}, {{-8.0, 2.0}, -1.5, 9.0}}, {1.0, 1.0});
}

TEST(Terrain, IsLevelWithoutHills) {
  const Terrain level;
  EXPECT_TRUE(level.isLevel());
  EXPECT_EQ(level.height({3.0, 4.0}), 0.0);
  EXPECT_EQ(level.stretch({3.0, 4.0, 1.0}), 1.0);
  EXPECT_FALSE(level.meet({{0.0, 0.0}, {1.0, 0.0}, 0.5, -0.1, 1.005}, 80.0));
}

TEST(Terrain, CountsHeightsFromItsDatum) {
  EXPECT_NEAR(twoHills().height({1.0, 1.0}), 0.0, 1e-15);
  EXPECT_GT(twoHills().height({10.0, 5.0}), 1.0);
}

TEST(Terrain, SlopesAsItsHeightsDiffer) {
  const Terrain terrain = twoHills();
  constexpr double kStep_m = 1e-5;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(14.0, -3.0)}) {
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep_m * Eigen::Vector2d::Unit(axis);
      const double difference = terrain.height(p + step) - terrain.height(p - step);
      EXPECT_NEAR(terrain.slope(p)[axis], difference / (2.0 * kStep_m), 1e-8);
    }
  }
}

TEST(Terrain, StandsWhatItCarriesUprightOnTheGround) {
  const Terrain terrain = twoHills();
  const Pose2 pose{4.0, 3.0, 0.7};
  const Eigen::Isometry3d T = terrain.standing(pose);
  EXPECT_TRUE(T.linear().isUnitary(1e-12));
  EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-12);
  EXPECT_NEAR(std::atan2(T(1, 0), T(0, 0)), pose.yaw_rad, 1e-12) << "its heading in plan";
  EXPECT_NEAR(T.translation().z(), terrain.height(pose.position()), 1e-15);
  const Eigen::Vector2d ahead = pose * Eigen::Vector2d(1e-4, 0.0);
  const Eigen::Vector3d on_ground(ahead.x(), ahead.y(), terrain.height(ahead));
  EXPECT_NEAR((T.inverse() * on_ground).z(), 0.0, 1e-8) << "its x axis touches the ground";
}

TEST(Terrain, MovesWithTheFrameThatItIsToldIn) {
  const Terrain terrain = twoHills();
  const Pose2 T{3.0, -2.0, 0.8};
  const Terrain moved = terrain.transformed(T);
  const Eigen::Vector2d p(4.0, 1.0);
  EXPECT_NEAR(moved.height(T * p), terrain.height(p), 1e-12);
  EXPECT_NEAR(moved.stretch(T * Pose2{p.x(), p.y(), 0.2}), terrain.stretch({p.x(), p.y(), 0.2}),
              1e-12);
}

TEST(Terrain, IsMetByABeamWhereItRisesAboveIt) {
  // A level beam, 1 m up, towards a hill of 2 m: the bell reaches 1 m where exp(-d^2 / 2) = 1/2.
  const Terrain hill({{{40.0, 0.0}, 2.0, 10.0}}, {-1000.0, 0.0});
  const auto hit = hill.meet({{0.0, 0.0}, {1.0, 0.0}, 1.0, 0.0, 1.0}, 80.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->plan_range_m, 40.0 - 10.0 * std::sqrt(2.0 * std::log(2.0)), 0.02);
  EXPECT_NEAR(hit->incidence_cosine, 0.117, 0.001);  // the slope there, 0.1 * sqrt(2 ln 2)
  EXPECT_FALSE(hill.meet({{0.0, 0.0}, {-1.0, 0.0}, 1.0, 0.0, 1.0}, 80.0));
  EXPECT_FALSE(hill.meet({{0.0, 0.0}, {1.0, 0.0}, 1.0, 0.0, 1.0}, 25.0)) << "out of range";
  EXPECT_FALSE(hill.meet({{0.0, 0.0}, {1.0, 0.0}, 2.1, 0.0, 1.0}, 80.0)) << "over its top";
}

TEST(BeamPlane, IsTheSameOnLevelGroundAsInPlan) {
  const Pose2 T_map_base{2.0, 3.0, 0.4}, T_base_laser{3.78, 0.5, 0.1};
  const Beam beam = BeamPlane(Terrain(), T_map_base, T_base_laser, 0.8).beam(0.3);
  const Pose2 T_map_laser = T_map_base * T_base_laser;
  EXPECT_EQ(beam.origin, T_map_laser.position());
  EXPECT_NEAR(std::atan2(beam.direction.y(), beam.direction.x()), 0.8, 1e-12);
  EXPECT_EQ(beam.stretch, 1.0);
}

TEST(BeamPlane, TiltsWithTheVehicle) {
  // Up a slope, beams ahead climb as it does, and those to the side do not.
  const Terrain hill({{{30.0, 0.0}, 3.0, 20.0}}, {0.0, 0.0});
  const Pose2 uphill{10.0, 0.0, 0.0};
  const double slope = hill.slope(uphill.position()).x();
  ASSERT_GT(slope, 0.05);
  const BeamPlane plane(hill, uphill, {}, 0.8);
  EXPECT_NEAR(plane.beam(0.0).climb, slope, 1e-12);
  EXPECT_NEAR(plane.beam(0.0).stretch, std::hypot(1.0, slope), 1e-12);
  EXPECT_NEAR(plane.beam(kPi / 2.0).climb, 0.0, 1e-12);
  EXPECT_GT(plane.beam(0.0).height_m, hill.height(uphill.position()) + 0.79);
}

SimulationConfig perfectDrive(double duration_s) {
  SimulationConfig config;
  config.world.name = "hills";
  config.drive.laps = 1;
  config.drive.duration_s = duration_s;
  config.motion.noise_scale = 0.0;
  config.motion.draw_calibration = false;
  config.laser.range_deviation_m = config.laser.range_deviation_relative = 0.0;
  config.laser.range_resolution_m = config.laser.dark_range_m = 0.0;
  config.laser.missed_return_probability = config.laser.spurious_return_probability = 0.0;
  return config;
}

TEST(Hills, AreNoSteeperWhereTheVehicleDrivesThanAnAsphaltRoad) {
  Simulation simulation(perfectDrive(0.0), simulatedCar(), 3);
  double steepest = 0.0;
  while (const auto simulated = simulation.next()) {
    steepest =
        std::max(steepest, simulation.terrain().slope(simulated->T_map_base.position()).norm());
  }
  EXPECT_GT(steepest, 0.1);
  EXPECT_LT(steepest, 0.125) << "0.12 on the route, which the car follows within centimetres";
}

TEST(Hills, EndEachBeamOnATrunkOrOnTheGround) {
  const SimulationConfig config = perfectDrive(40.0);
  Simulation simulation(config, simulatedCar(), 4);
  const auto landmarks = simulation.landmarks();
  const Terrain& terrain = simulation.terrain();
  std::size_t trunks = 0, ground = 0;
  while (const auto simulated = simulation.next()) {
    const auto* scan = std::get_if<ScanEvent>(&simulated->event);
    if (scan == nullptr) continue;
    const BeamPlane plane(terrain, simulated->T_map_base, scan->T_base_laser,
                          config.laser.height_m);
    for (std::size_t i = 0; i < scan->scan.ranges_m.size(); ++i) {
      const auto range = static_cast<double>(scan->scan.ranges_m[i]);
      if (!std::isfinite(range)) continue;
      const Beam beam = plane.beam(scan->scan.bearing(i));
      const double in_plan = range / beam.stretch;
      const Eigen::Vector2d end = beam.origin + in_plan * beam.direction;
      const int id = simulated->beam_landmarks[i];
      if (id >= 0) {
        const TrueLandmark& landmark = landmarks[static_cast<std::size_t>(id)];
        EXPECT_NEAR((end - landmark.position).norm(), landmark.diameter_m / 2.0, 1e-4);
        ++trunks;
      } else {
        // Grass is rough by 3 cm along the beam, and beams come down at up to 0.3 m a metre.
        EXPECT_NEAR(beam.height_m + in_plan * beam.climb, terrain.height(end), 0.1);
        ++ground;
      }
    }
  }
  EXPECT_GT(trunks, 500U);
  EXPECT_GT(ground, 500U);
}

TEST(Hills, LetTheWheelsRollFartherThanThePlanTells) {
  SimulationConfig config = perfectDrive(0.0);
  config.laser.enabled = false;
  VehicleConfig car = simulatedCar();
  car.ackermann.encoder_offset_left_m = 0.0;
  Simulation simulation(config, car, 4);
  std::optional<SimulatedEvent> last;
  double rolled = 0.0, in_space = 0.0, in_plan = 0.0;
  const Terrain& terrain = simulation.terrain();
  while (auto simulated = simulation.next()) {
    if (!std::holds_alternative<MotionInput>(simulated->event)) continue;
    if (last) {
      const auto& input = std::get<AckermannInput>(std::get<MotionInput>(last->event));
      rolled += input.speed_mps * (timeOf(simulated->event) - timeOf(last->event));
      const Eigen::Vector2d from = last->T_map_base.position();
      const Eigen::Vector2d to = simulated->T_map_base.position();
      in_plan += (to - from).norm();
      in_space += std::hypot((to - from).norm(), terrain.height(to) - terrain.height(from));
    }
    last = std::move(simulated);
  }
  EXPECT_NEAR(rolled, in_space, 1e-3 * (in_space - in_plan) + 1e-3);
  EXPECT_GT(in_space - in_plan, 0.2);
}

TEST(Hills, TellTheHeightWithEachScanAndOtherWorldsDoNot) {
  SimulationConfig config = perfectDrive(30.0);
  Simulation simulation(config, simulatedCar(), 5);
  double sum = 0.0;
  int count = 0;
  while (const auto simulated = simulation.next()) {
    EXPECT_EQ(simulated->height_m.has_value(), std::holds_alternative<ScanEvent>(simulated->event));
    if (!simulated->height_m) continue;
    const double truth = simulation.terrain().height(simulated->T_map_base.position());
    sum += std::pow((*simulated->height_m - truth) / config.altimeter.deviation_m, 2);
    ++count;
  }
  ASSERT_EQ(count, 150);
  EXPECT_GT(sum / count, 0.65);  // 3 deviations of the mean of 150 squares are 0.35
  EXPECT_LT(sum / count, 1.35);
  config.world.name = "park";
  Simulation level(config, simulatedCar(), 5);
  while (const auto simulated = level.next()) EXPECT_FALSE(simulated->height_m);
}

}  // namespace
}  // namespace hymm::core
