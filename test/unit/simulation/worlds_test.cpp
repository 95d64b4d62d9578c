#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "simulated_drives.h"
#include "simulation/world_catalog.h"
#include "vehicle/dead_reckoning.h"

namespace hymm::core {
namespace {

/// Numbers that stand for everything that the events hold.
std::vector<double> digest(const std::vector<SimulatedEvent>& events) {
  std::vector<double> numbers;
  for (const SimulatedEvent& e : events) {
    numbers.insert(numbers.end(), {timeOf(e.event), e.T_map_base.x_m, e.T_map_base.yaw_rad});
    if (const auto* scan = std::get_if<ScanEvent>(&e.event)) {
      const auto& ranges = scan->scan.ranges_m;
      numbers.insert(numbers.end(), ranges.begin(), ranges.end());
      const auto& intensities = scan->scan.intensities;
      numbers.insert(numbers.end(), intensities.begin(), intensities.end());
    } else if (const auto* motion = std::get_if<MotionInput>(&e.event)) {
      if (const auto* encoders = std::get_if<AckermannInput>(motion)) {
        numbers.insert(numbers.end(), {encoders->speed_mps, encoders->steering_rad});
      }
    } else if (const auto* fix = std::get_if<GpsFix>(&e.event)) {
      numbers.insert(numbers.end(), {fix->position.x(), fix->position.y()});
    }
  }
  return numbers;
}

class EveryWorld : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld, testing::ValuesIn(worldNames()),
                         [](const auto& world) { return world.param; });

TEST_P(EveryWorld, IsTheSameForTheSameSeed) {
  const auto first = digest(all(shortDrive(GetParam()), 5));
  EXPECT_EQ(first, digest(all(shortDrive(GetParam()), 5)));
  EXPECT_NE(first, digest(all(shortDrive(GetParam()), 6)));
}

TEST_P(EveryWorld, StartsAtTheMapsOriginAtRest) {
  const SimulationConfig config = shortDrive(GetParam(), 1.0);
  const auto events = all(config);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(timeOf(events.front().event), Simulation::kStartTime_s);
  for (const SimulatedEvent& event : events) {
    if (timeOf(event.event) > Simulation::kStartTime_s) break;
    EXPECT_NEAR(event.T_map_base.vector().norm(), 0.0, 1e-9);
  }
}

TEST_P(EveryWorld, YieldsEventsInOrderOfTime) {
  double last_s = 0.0;
  for (const SimulatedEvent& event : all(shortDrive(GetParam()))) {
    EXPECT_GE(timeOf(event.event), last_s);
    last_s = timeOf(event.event);
  }
}

TEST_P(EveryWorld, ClosesItsLaps) {
  SimulationConfig config = perfect(GetParam());
  config.laser.enabled = false;
  const auto events = all(config);
  const Pose2 end = events.back().T_map_base;
  EXPECT_LT(end.position().norm(), 0.5);
  EXPECT_LT(std::abs(end.yaw_rad), 0.1);
}

TEST_P(EveryWorld, NeverDrivesThroughAnythingSolid) {
  SimulationConfig config = perfect(GetParam());
  const VehicleConfig car = simulatedCar();
  Simulation simulation(config, car, 3);
  const TrueOccupancy map = simulation.occupancy(0.1);
  const double front = car.length_m - car.rear_overhang_m;
  for (const SimulatedEvent& event : all(simulation)) {
    if (!std::holds_alternative<ScanEvent>(event.event)) continue;
    for (double x = -car.rear_overhang_m; x <= front; x += 0.1) {
      for (double y = -car.width_m / 2.0; y <= car.width_m / 2.0; y += 0.1) {
        const Eigen::Vector2d p = event.T_map_base * Eigen::Vector2d(x, y) - map.origin;
        const auto column = static_cast<std::size_t>(p.x() / map.resolution_m);
        const auto row = static_cast<std::size_t>(p.y() / map.resolution_m);
        ASSERT_FALSE(map.occupied[row * static_cast<std::size_t>(map.width) + column])
            << "at " << timeOf(event.event) << " s";
      }
    }
  }
}

TEST_P(EveryWorld, HoldsAsManyLandmarksAsAskedFor) {
  SimulationConfig config = shortDrive(GetParam());
  config.world.landmarks = 90;
  const Simulation simulation(config, simulatedCar(), 2);
  ASSERT_EQ(simulation.landmarks().size(), 90U);
  for (std::size_t i = 0; i < 90; ++i) {
    EXPECT_EQ(simulation.landmarks()[i].id, static_cast<int>(i));
    EXPECT_GT(simulation.landmarks()[i].diameter_m, 0.0);
  }
}

/// Names of the worlds without hills, where what is measured in the laser's plane holds in plan.
std::vector<std::string> levelWorldNames() {
  std::vector<std::string> names = worldNames();
  names.erase(std::remove(names.begin(), names.end(), "hills"), names.end());
  return names;
}

class LevelWorld : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Worlds, LevelWorld, testing::ValuesIn(levelWorldNames()),
                         [](const auto& world) { return world.param; });

TEST_P(LevelWorld, DeadReckoningOfPerfectEncodersIsTheTruth) {
  SimulationConfig config = perfect(GetParam());
  config.laser.enabled = false;
  DeadReckoning dead_reckoning(simulatedCar());
  double worst = 0.0;
  for (const SimulatedEvent& event : all(config)) {
    const auto* motion = std::get_if<MotionInput>(&event.event);
    if (motion == nullptr) continue;
    ASSERT_TRUE(dead_reckoning.process(*motion));
    const Pose2 error = inverse(event.T_map_base) * dead_reckoning.T_odom_base();
    worst = std::max(worst, error.vector().norm());
  }
  EXPECT_LT(worst, 1e-6);
}

TEST_P(LevelWorld, ShowsLandmarksWhereTheyStand) {
  // Each beam that met a landmark first ends on its surface; to the left is positive.
  SimulationConfig config = perfect(GetParam());
  config.laser.beam_width_rad = 0.0;
  config.drive.duration_s = 30.0;
  Simulation simulation(config, simulatedCar(), 4);
  const auto landmarks = simulation.landmarks();
  std::size_t seen = 0;
  for (const SimulatedEvent& event : all(simulation)) {
    const auto* scan = std::get_if<ScanEvent>(&event.event);
    if (scan == nullptr) continue;
    ASSERT_EQ(event.beam_landmarks.size(), scan->scan.ranges_m.size());
    for (std::size_t i = 0; i < event.beam_landmarks.size(); ++i) {
      if (event.beam_landmarks[i] < 0) continue;
      const double range = static_cast<double>(scan->scan.ranges_m[i]);
      const double bearing = scan->scan.bearing(i);
      const Eigen::Vector2d end(range * std::cos(bearing), range * std::sin(bearing));
      const auto& landmark = landmarks[static_cast<std::size_t>(event.beam_landmarks[i])];
      const double distance =
          (event.T_map_base * (scan->T_base_laser * end) - landmark.position).norm();
      EXPECT_NEAR(distance, landmark.diameter_m / 2.0, 1e-4);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100U);
}

TEST(Worlds, HoldAsManyPeopleAndCarsAsAskedFor) {
  WorldConfig config;
  config.people = 7;
  config.moving_cars = 2;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomGenerator generator(seed);
    config.name = "park";
    EXPECT_EQ(makeWorld(config, simulatedCar(), generator).movers.size(), 7U);
    config.name = "car_park";
    EXPECT_EQ(makeWorld(config, simulatedCar(), generator).movers.size(), 9U);
  }
}

TEST(Worlds, KeepWhatMovesAwayFromTheVehiclesRoute) {
  const VehicleConfig car = simulatedCar();
  for (const std::string& name : worldNames()) {
    WorldConfig config;
    config.name = name;
    RandomGenerator generator(3);
    const World world = makeWorld(config, car, generator);
    for (const Mover& mover : world.movers) {
      for (double s = 0.0; s < mover.path.length_m(); s += 0.5) {
        const Shape body = transformed(mover.path.at(s), mover.body);
        for (const Eigen::Vector2d& point : world.route.points()) {
          ASSERT_GT(distanceBetween(point, body), car.width_m / 2.0) << name;
        }
      }
    }
  }
}

TEST(Simulation, PutsOneLandmarkOnEach100SquareMetresOfThePlain) {
  SimulationConfig config = shortDrive("plain");
  config.world.landmarks = 400;
  const Simulation simulation(config, simulatedCar(), 1);
  Eigen::AlignedBox2d bounds;
  for (const TrueLandmark& landmark : simulation.landmarks()) {
    bounds.extend(simulation.T_enu_map() * landmark.position);
  }
  EXPECT_LE(bounds.sizes().maxCoeff(), 200.0);
  EXPECT_NEAR(bounds.volume() / 400.0, 100.0, 3.0);
}

TEST(Simulation, DrivesTheWholePlain) {
  SimulationConfig config = perfect("plain");
  config.world.landmarks = 1000;
  config.laser.enabled = false;
  config.detections.enabled = true;
  config.detections.identities = true;
  config.detections.range_max_m = 28.0;
  config.detections.rate_hz = 1.0;
  Simulation simulation(config, simulatedCar(), 1);
  std::vector<bool> seen(1000, false);
  for (const SimulatedEvent& event : all(simulation)) {
    const auto* set = std::get_if<ObservationSet>(&event.event);
    if (set == nullptr) continue;
    for (const Observation& o : set->observations)
      seen[static_cast<std::size_t>(o.identity)] = true;
  }
  EXPECT_GT(std::count(seen.begin(), seen.end(), true), 980);
}

}  // namespace
}  // namespace hymm::core
