#include "cekf/vehicle_state.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

constexpr double kStep = 1e-6;
constexpr double kNumeric = 1e-7;

const Pose2 kMounting{3.78, 0.5, 0.1};

/// A car in a curve, with every error of its laser among the states.
struct Car {
  Car()
      : vehicle(config(), false, false),
        filter(vehicle.initialState(), vehicle.initialCovariance()) {
    vehicle.takeInput(filter, AckermannInput{0.0, 3.0, 0.3});
    vehicle.takeInput(filter, AckermannInput{1.0, 3.0, 0.3});
  }

  static VehicleConfig config() {
    VehicleConfig config;
    config.ackermann.encoder_offset_left_m = 0.76;
    config.calibration.laser_yaw_deviation_rad = 0.02;
    config.calibration.laser_range_offset_deviation_m = 0.04;
    config.calibration.laser_time_offset_deviation_s = 0.1;
    return config;
  }

  /// What the laser measures of a landmark, with these errors.
  Eigen::Vector2d measured(const Eigen::Vector3d& errors) {
    for (int k = 0; k < 3; ++k) filter.setVehicleState(5 + k, errors[k]);
    const SensorPlacement sensor = vehicle.placement(kMounting, filter.vehicle());
    Eigen::Vector2d z =
        predictRangeBearing(VehicleState::pose(filter), sensor.T_base_sensor, {14.0, 9.0}).value;
    z[0] += sensor.range_offset_m;
    return z;
  }

  VehicleState vehicle;
  CompressedEkf filter;
};

TEST(VehicleState, HasJacobiansByTheLasersErrors) {
  Car car;
  const Eigen::Vector3d errors(0.01, 0.05, -0.04);
  car.measured(errors);
  const SensorPlacement sensor = car.vehicle.placement(kMounting, car.filter.vehicle());
  const RangeBearing z =
      predictRangeBearing(VehicleState::pose(car.filter), sensor.T_base_sensor, {14.0, 9.0});
  const auto H = vehicleJacobian(z, sensor, car.filter.vehicleStates());
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d numeric =
        (car.measured(errors + step) - car.measured(errors - step)) / (2.0 * kStep);
    EXPECT_LT((H.col(5 + k) - numeric).norm(), kNumeric) << k;
  }
}

TEST(VehicleState, MeasuresFromWhereTheVehicleWasAtTheTimeOfMeasuring) {
  Car before, after;
  before.vehicle.moveTo(before.filter, 1.2);
  after.vehicle.moveTo(after.filter, 1.4);
  after.filter.setVehicleState(7, -0.2);
  const SensorPlacement sensor = after.vehicle.placement(kMounting, after.filter.vehicle());
  const Pose2 found = VehicleState::pose(after.filter) * sensor.T_base_sensor;
  const Pose2 expected = VehicleState::pose(before.filter) * kMounting;
  EXPECT_LT((found.vector() - expected.vector()).norm(), 1e-12);
}

TEST(VehicleState, LeavesOutWhatIsKnownForCertain) {
  const VehicleState vehicle(VehicleConfig{}, false, false);
  const CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance());
  const SensorPlacement sensor = vehicle.placement(kMounting, filter.vehicle());
  EXPECT_EQ(vehicle.size(), 5);
  EXPECT_EQ(sensor.range_offset_state, -1);
  EXPECT_EQ(sensor.time_offset_state, -1);
  EXPECT_EQ(vehicle.laserCalibration(filter).deviation, Eigen::Vector3d::Zero());
}

/// Deviation of the heading after a turn of some seconds, to the left and at once to the right or
/// to the left again.
double headingDeviationAfterTurns(double persists_s, double second_steering_rad) {
  VehicleConfig config;
  config.noise.steering_deviation_rad = 0.0;
  config.noise.steering_deviation_relative = 0.05;
  config.noise.turn_relative_correlation_time_s = persists_s;
  VehicleState vehicle(config, false, false);
  CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance());
  for (int i = 0; i <= 40; ++i) {
    vehicle.takeInput(filter, AckermannInput{0.1 * i, 3.0, i < 20 ? 0.3 : second_steering_rad});
  }
  return std::sqrt(filter.vehicleCovariance()(2, 2));
}

TEST(VehicleState, CarriesTheRelativeErrorOfTheTurnAsAStateWhereThereIsOne) {
  VehicleConfig config;
  const int without = VehicleState(config, false, false).size();
  config.noise.steering_deviation_relative = 0.05;
  EXPECT_EQ(VehicleState(config, false, false).size(), without + 1);
}

TEST(VehicleState, LetsARelativeErrorThatPersistsCancelBetweenLeftAndRight) {
  EXPECT_GT(headingDeviationAfterTurns(60.0, 0.3), 2.0 * headingDeviationAfterTurns(0.2, 0.3));
  EXPECT_LT(headingDeviationAfterTurns(60.0, -0.3), 0.2 * headingDeviationAfterTurns(60.0, 0.3));
}

/// Turning the whole map about its origin moves the vehicle like this, and nothing measures it.
Eigen::VectorXd turnOfTheMap(const Eigen::Vector2d& position, int states) {
  Eigen::VectorXd turn = Eigen::VectorXd::Zero(states);
  turn.head<3>() << -position.y(), position.x(), 1.0;
  return turn;
}

/// Drives, is corrected, and drives on, with nothing unknown but the heading of the whole map.
/// Returns how far its covariance then is from that of the same unknown.
double inventedKnowledge(bool at_first_estimates) {
  const VehicleConfig config;
  // What the motion's noise adds is the same in both filters: the difference is the map's heading.
  std::vector<Eigen::MatrixXd> covariances;
  Eigen::Vector2d place;
  for (const double unknown : {1.0, 0.0}) {
    VehicleState vehicle(config, false, false, at_first_estimates);
    const Eigen::VectorXd turn = unknown * turnOfTheMap(Eigen::Vector2d::Zero(), vehicle.size());
    CompressedEkf filter(vehicle.initialState(), turn * turn.transpose());
    vehicle.takeInput(filter, AckermannInput{0.0, 3.0, 0.2});
    vehicle.moveTo(filter, 1.0);
    const Eigen::VectorXd state = filter.vehicle();
    filter.setVehicleState(0, state[0] + 0.5);
    filter.setVehicleState(1, state[1] - 0.8);
    vehicle.moveTo(filter, 2.0);
    covariances.push_back(filter.vehicleCovariance());
    place = vehicle.linearisedAt();
  }
  const Eigen::VectorXd turn = turnOfTheMap(place, static_cast<int>(covariances[0].rows()));
  return (covariances[0] - covariances[1] - turn * turn.transpose()).norm();
}

TEST(VehicleState, KeepsTheHeadingOfTheMapUnknownAtFirstEstimatesOnly) {
  EXPECT_LT(inventedKnowledge(true), 1e-9);
  EXPECT_GT(inventedKnowledge(false), 0.1);
}

TEST(VehicleState, GoesOnByTheInputInForceAndThenByThoseThatFollow) {
  VehicleState vehicle(VehicleConfig{}, true, false);
  CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance());
  EXPECT_TRUE(vehicle.motionFrom(filter, {}).isStill());
  vehicle.takeInput(filter, TwistInput{1.0, 5.0, 0.0, 0.2});
  vehicle.moveTo(filter, 1.02);
  const SweepMotion motion = vehicle.motionFrom(
      filter, {TwistInput{1.04, 5.0, 0.0, 0.4}, TwistInput{1.06, 0.0, 0.0, 0.0}});
  ASSERT_EQ(motion.pieces.size(), 3U);
  EXPECT_NEAR(motion.pieces[1].from_s, 0.02, 1e-12);
  EXPECT_EQ(motion.pieces[1].yaw_rate_radps, 0.4);
  const Pose2 pose = motion.poseAfter(0.1);
  EXPECT_NEAR(pose.yaw_rad, 0.02 * 0.2 + 0.02 * 0.4, 1e-12);
  EXPECT_NEAR(pose.x_m, 0.2, 1e-4);
}

TEST(VehicleState, MovesOnAsItPredictsItself) {
  // With errors of the input estimated: what tells the motion within a scan, and what takes the
  // filter to the next, are the same.
  Car car;
  car.filter.setVehicleState(3, 0.7);
  car.filter.setVehicleState(4, -1.2);
  const Pose2 before = VehicleState::pose(car.filter);
  const SweepMotion motion = car.vehicle.motionFrom(car.filter, {AckermannInput{1.03, 2.0, 0.1}});
  car.vehicle.takeInput(car.filter, AckermannInput{1.03, 2.0, 0.1});
  car.vehicle.moveTo(car.filter, 1.1);
  const Pose2 error = inverse(VehicleState::pose(car.filter)) * (before * motion.poseAfter(0.1));
  EXPECT_LT(error.vector().norm(), 1e-9);
}

TEST(VehicleState, KnowsItsVelocityAsWellAsTheErrorsOfItsInput) {
  VehicleConfig config;
  VehicleState vehicle(config, true, false);
  CompressedEkf filter(vehicle.initialState(), vehicle.initialCovariance());
  vehicle.takeInput(filter, TwistInput{0.0, 5.0, 0.0, 0.0});
  vehicle.moveTo(filter, 0.0);
  const Eigen::Matrix3d C = vehicle.motionFrom(filter, {}).velocity_covariance;
  EXPECT_NEAR(C(2, 2), std::pow(config.noise.yaw_rate_deviation_radps, 2), 1e-12);
  EXPECT_NEAR(C(0, 0),
              std::pow(config.noise.speed_deviation_mps, 2) +
                  std::pow(5.0 * config.noise.speed_deviation_relative, 2),
              1e-12);
}

}  // namespace
}  // namespace hymm::core
