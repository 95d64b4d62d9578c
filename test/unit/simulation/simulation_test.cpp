#include "simulation/simulation.h"

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/chi_square.h"
#include "common/error.h"
#include "simulated_drives.h"

namespace hymm::core {
namespace {

TEST(Simulation, ReportsTheEncodersWheelAndNotTheCarsMiddle) {
  // In a left turn the left wheel runs on the smaller circle.
  SimulationConfig config = perfect("plain");
  config.laser.enabled = false;
  const VehicleConfig car = simulatedCar();
  std::size_t turns = 0;
  const auto events = all(config);
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    const auto* motion = std::get_if<MotionInput>(&events[i].event);
    const auto* next = std::get_if<MotionInput>(&events[i + 1].event);
    if (motion == nullptr || next == nullptr) continue;
    const auto& input = std::get<AckermannInput>(*motion);
    if (std::abs(input.steering_rad) < 0.1) continue;
    const double t = std::tan(input.steering_rad) / car.ackermann.wheelbase_m;
    const double driven =
        (events[i + 1].T_map_base.position() - events[i].T_map_base.position()).norm();
    const double wheel = input.speed_mps * (timeOf(*next) - timeOf(*motion));
    EXPECT_NEAR(wheel, driven * (1.0 - t * car.ackermann.encoder_offset_left_m), 1e-5);
    ++turns;
  }
  EXPECT_GT(turns, 100U);
}

/// Mean of squares of unit normal variables against the chi-square band.
void expectUnitVariance(double sum_of_squares, int count) {
  EXPECT_GT(sum_of_squares, chiSquareQuantile(0.0005, count));
  EXPECT_LT(sum_of_squares, chiSquareQuantile(0.9995, count));
}

TEST(Simulation, EncodersHaveTheNoiseThatTheVehicleClaims) {
  // Samples five correlation times apart are independent enough (e^-5).
  SimulationConfig config = shortDrive("park", 0.0);
  config.laser.enabled = false;
  config.motion.draw_calibration = false;
  VehicleConfig car = simulatedCar();
  car.ackermann.encoder_offset_left_m = 0.0;
  car.noise.lateral_deviation_relative = 0.0;
  car.noise.steering_deviation_relative = 0.05;
  Simulation simulation(config, car, 11);
  const auto events = all(simulation);
  double speed_sum = 0.0, turn_sum = 0.0, used_s = 0.0;
  int count = 0;
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    const auto* motion = std::get_if<MotionInput>(&events[i].event);
    if (motion == nullptr || timeOf(*motion) < used_s + 1.0) continue;
    const double dt = timeOf(events[i + 1].event) - timeOf(*motion);
    if (dt < 1e-3) continue;
    used_s = timeOf(*motion);
    const auto& input = std::get<AckermannInput>(*motion);
    const Pose2 step = inverse(events[i].T_map_base) * events[i + 1].T_map_base;
    const double speed = step.position().norm() / dt;
    if (speed < 0.5) continue;
    const double steering = std::atan(step.yaw_rad / dt / speed * car.ackermann.wheelbase_m);
    const double deviation =
        std::hypot(car.noise.speed_deviation_mps, car.noise.speed_deviation_relative * speed);
    speed_sum += std::pow((input.speed_mps - speed) / deviation, 2);
    const double steering_deviation = std::hypot(car.noise.steering_deviation_rad,
                                                 car.noise.steering_deviation_relative * steering);
    turn_sum += std::pow((input.steering_rad - steering) / steering_deviation, 2);
    ++count;
  }
  ASSERT_GT(count, 200);
  expectUnitVariance(speed_sum, count);
  expectUnitVariance(turn_sum, count);
}

TEST(Simulation, DrawsTheCalibrationFromTheVehiclesPrior) {
  SimulationConfig config = shortDrive("plain", 0.1);
  const VehicleConfig car = simulatedCar();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Calibration c = Simulation(config, car, seed).calibration();
    const Eigen::Array3d error =
        (c.vector() - Calibration{}.vector()).array() /
        Eigen::Array3d(car.calibration.speed_scale_deviation, car.calibration.turn_scale_deviation,
                       car.calibration.steering_offset_deviation_rad);
    sums += error.square().matrix();
  }
  for (int i = 0; i < 3; ++i) expectUnitVariance(sums[i], kSeeds);
}

TEST(Simulation, MeasuresWhatItsCalibrationSays) {
  SimulationConfig config = perfect("park");
  config.laser.enabled = false;
  const auto ideal = all(config);
  config.motion.speed_scale = 1.03;
  config.motion.turn_scale = 0.97;
  config.motion.turn_offset = 0.02;
  const auto wrong = all(config);
  ASSERT_EQ(ideal.size(), wrong.size());
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    const auto* motion = std::get_if<MotionInput>(&ideal[i].event);
    if (motion == nullptr) continue;
    const auto& truth = std::get<AckermannInput>(*motion);
    const auto& measured = std::get<AckermannInput>(std::get<MotionInput>(wrong[i].event));
    EXPECT_NEAR(1.03 * measured.speed_mps, truth.speed_mps, 1e-12);
    EXPECT_NEAR(0.97 * measured.steering_rad + 0.02, truth.steering_rad, 1e-12);
  }
}

TEST(Simulation, DetectionsHaveTheCovarianceThatTheyCarry) {
  SimulationConfig config = shortDrive("park", 60.0);
  config.laser.enabled = false;
  config.detections.enabled = true;
  config.detections.identities = true;
  Simulation simulation(config, simulatedCar(), 9);
  const auto landmarks = simulation.landmarks();
  double sum = 0.0;
  int count = 0;
  for (const SimulatedEvent& event : all(simulation)) {
    const auto* set = std::get_if<ObservationSet>(&event.event);
    if (set == nullptr) continue;
    const Pose2 T_sensor_map = inverse(event.T_map_base * set->T_base_sensor);
    for (const Observation& o : set->observations) {
      const Eigen::Vector2d p =
          T_sensor_map * landmarks[static_cast<std::size_t>(o.identity)].position;
      const Eigen::Vector2d error(o.range_m - p.norm(),
                                  wrapAngle(o.bearing_rad - std::atan2(p.y(), p.x())));
      sum += error.dot(o.covariance.inverse() * error);
      count += 2;
    }
  }
  ASSERT_GT(count, 500);
  expectUnitVariance(sum, count);
}

TEST(Simulation, DrivesTheCarOfTheVehicleFile) {
  const char* const source = std::getenv("HYMM_SOURCE_DIR");
  ASSERT_NE(source, nullptr);
  const std::string file = std::string(source) + "/config/vehicles/simulated_car.yaml";
  VehicleConfig read, built_in = simulatedCar();
  ConfigReport report;
  readConfig(YAML::LoadFile(file)["vehicle"], read, file, report);
  EXPECT_TRUE(report.errors.empty());
  EXPECT_TRUE(report.warnings.empty());
  ConfigSchema a, b;
  read.describe(a);
  built_in.describe(b);
  for (std::size_t i = 0; i < a.entries().size(); ++i) {
    EXPECT_EQ(a.entries()[i].path, b.entries()[i].path);
    if (const auto* number = std::get_if<double*>(&a.entries()[i].value)) {
      EXPECT_EQ(**number, *std::get<double*>(b.entries()[i].value)) << a.entries()[i].path;
    } else if (const auto* text = std::get_if<std::string*>(&a.entries()[i].value)) {
      EXPECT_EQ(**text, *std::get<std::string*>(b.entries()[i].value)) << a.entries()[i].path;
    }
  }
}

TEST(Simulation, TellsNoIdentitiesUnlessAsked) {
  SimulationConfig config = shortDrive("park");
  config.detections.enabled = true;
  std::size_t observations = 0;
  for (const SimulatedEvent& event : all(config)) {
    const auto* set = std::get_if<ObservationSet>(&event.event);
    if (set == nullptr) continue;
    for (const Observation& o : set->observations) {
      EXPECT_EQ(o.identity, -1);
      ++observations;
    }
  }
  EXPECT_GT(observations, 50U);
}

TEST(Simulation, FixesThePlaceOfTheAntenna) {
  SimulationConfig config = shortDrive("park", 60.0);
  config.laser.enabled = false;
  config.gps.deviation_m = config.gps.drift_deviation_m = 0.0;
  config.gps.outage_interval_s = config.gps.jump_interval_s = 0.0;
  VehicleConfig car = simulatedCar();
  car.gps_antenna = {1.0, -0.5, 0.0};
  Simulation simulation(config, car, 1);
  std::size_t fixes = 0;
  const Pose2 T_enu_map = simulation.T_enu_map();
  for (const SimulatedEvent& event : all(simulation)) {
    const auto* fix = std::get_if<GpsFix>(&event.event);
    if (fix == nullptr) continue;
    ++fixes;
    const Eigen::Vector2d antenna = T_enu_map * (event.T_map_base * Eigen::Vector2d(1.0, -0.5));
    EXPECT_LT((fix->position - antenna).norm(), 1e-9);
    EXPECT_EQ(fix->antenna, Eigen::Vector2d(1.0, -0.5));
  }
  EXPECT_EQ(fixes, 60U);
}

TEST(Simulation, LosesFixesInOutages) {
  SimulationConfig config = shortDrive("park", 0.0);
  config.laser.enabled = false;
  config.gps.outage_interval_s = config.gps.outage_duration_s = 10.0;
  std::size_t fixes = 0;
  double last_s = 0.0;
  for (const SimulatedEvent& event : all(config)) {
    last_s = timeOf(event.event);
    fixes += std::holds_alternative<GpsFix>(event.event) ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(fixes), 0.3 * last_s);
  EXPECT_LT(static_cast<double>(fixes), 0.7 * last_s);
}

TEST(Simulation, RefusesAVehicleThatCannotTakeTheCurves) {
  VehicleConfig lorry = simulatedCar();
  lorry.ackermann.wheelbase_m = 9.0;
  lorry.ackermann.encoder_offset_left_m = 0.0;
  EXPECT_THROW(Simulation(shortDrive("car_park"), lorry, 1), ConfigError);
}

TEST(Simulation, RefusesAnUnknownWorldAndNamesTheNearest) {
  try {
    Simulation(shortDrive("car_pork"), simulatedCar(), 1);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("'car_park'"), std::string::npos) << error.what();
  }
}

TEST(Simulation, CarriesTheCarWithItsSensorsCoveredAndItsWheelsAtRest) {
  SimulationConfig config = shortDrive("park");
  const auto driven = all(config);
  config.drive.carried_at_s = 8.0;
  config.drive.carried_for_s = 4.0;
  const auto carried = all(config);
  for (const SimulatedEvent& e : carried) {
    if (!config.drive.isCarriedAt(timeOf(e.event))) continue;
    const auto* motion = std::get_if<MotionInput>(&e.event);
    ASSERT_NE(motion, nullptr);
    EXPECT_EQ(std::get<AckermannInput>(*motion).speed_mps, 0.0);
  }
  EXPECT_LT(carried.size(), driven.size());
  EXPECT_EQ(carried.back().T_map_base.vector(), driven.back().T_map_base.vector());
}

TEST(Simulation, ARotatingLasersScanComesWhenItIsCompleteWithTheStampOfItsFirstBeam) {
  SimulationConfig config = shortDrive("park", 5.0);
  config.laser.rotating = true;
  config.laser.rate_hz = 10.0;
  double last_s = 0.0;
  std::size_t scans = 0;
  for (const SimulatedEvent& simulated : all(config)) {
    const auto* scan = std::get_if<ScanEvent>(&simulated.event);
    if (scan != nullptr) {
      ++scans;
      EXPECT_NEAR(scan->scan.sweep_s(), 0.05, 1e-9);  // half a turn
      EXPECT_GE(endOf(simulated.event), last_s - 1e-9);
    }
    last_s = endOf(simulated.event);
  }
  EXPECT_GE(scans, 45U);
}

TEST(Simulation, ALaserThatRotatesTooSlowlyToBeBelievedIsRefused) {
  SimulationConfig config;
  config.laser.rotating = true;
  config.laser.rate_hz = 0.5;
  EXPECT_THROW(Simulation(config, simulatedCar(), 1), ConfigError);
}

}  // namespace
}  // namespace hymm::core
