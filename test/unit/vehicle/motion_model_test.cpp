#include "vehicle/motion_model.h"

#include <cmath>
#include <functional>
#include <limits>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/error.h"

namespace hymm::core {
namespace {

using Jacobian = Eigen::Matrix3d;
using Function = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// By central differences. The third component of the results is an angle.
Jacobian numericJacobian(const Function& function, const Eigen::Vector3d& at) {
  const double h = 1e-5;
  Jacobian J;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = Eigen::Vector3d::Unit(i) * h;
    Eigen::Vector3d change = function(at + d) - function(at - d);
    change.z() = wrapAngle(change.z());
    J.col(i) = change / (2.0 * h);
  }
  return J;
}

double anyNumber(double low, double high) {
  return low + *rc::gen::inRange(0, 1'000'001) * 1e-6 * (high - low);
}

VehicleConfig utilityCar() {
  VehicleConfig vehicle;
  vehicle.ackermann.wheelbase_m = 2.83;
  vehicle.ackermann.encoder_offset_left_m = 0.76;
  return vehicle;
}

AckermannInput anyAckermannInput() { return {0.0, anyNumber(-5.0, 20.0), anyNumber(-0.6, 0.6)}; }

TwistInput anyTwistInput() {
  return {0.0, anyNumber(-5.0, 20.0), anyNumber(-2.0, 2.0), anyNumber(-2.0, 2.0)};
}

MotionInput anyInput() {
  return *rc::gen::arbitrary<bool>() ? MotionInput(anyAckermannInput())
                                     : MotionInput(anyTwistInput());
}

Calibration anyCalibration() {
  return {anyNumber(0.8, 1.2), anyNumber(0.8, 1.2), anyNumber(-0.05, 0.05)};
}

Pose2 anyPose() {
  return {anyNumber(-100.0, 100.0), anyNumber(-100.0, 100.0), anyNumber(-kPi, kPi)};
}

Eigen::Vector3d vectorOf(const BodyVelocity& v) {
  return {v.forward_mps, v.lateral_mps, v.yaw_rate_radps};
}

/// Central differences of functions of this size, with this step, are good to about this.
constexpr double kNumericJacobianError = 1e-7;

RC_GTEST_PROP(MotionModel, HasTheCalibrationJacobianOfItsVelocity, ()) {
  const MotionModel model(utilityCar());
  const MotionInput input = anyInput();
  const Calibration calibration = anyCalibration();
  const Jacobian numeric = numericJacobian(
      [&](const Eigen::Vector3d& c) {
        return vectorOf(model.velocity(input, Calibration::fromVector(c)));
      },
      calibration.vector());
  const Jacobian analytic = model.velocity(input, calibration).J_calibration;
  RC_ASSERT((analytic - numeric).norm() < kNumericJacobianError * (1.0 + numeric.norm()));
}

RC_GTEST_PROP(MotionModel, HasThePoseJacobianOfItsStep, ()) {
  const MotionModel model(utilityCar());
  const MotionInput input = anyInput();
  const Calibration calibration = anyCalibration();
  const Pose2 pose = anyPose();
  const double duration_s = anyNumber(0.001, 1.0);
  const Jacobian numeric = numericJacobian(
      [&](const Eigen::Vector3d& p) {
        return model.step(Pose2::fromVector(p), input, calibration, 0.0, duration_s).pose.vector();
      },
      pose.vector());
  const Jacobian analytic = model.step(pose, input, calibration, 0.0, duration_s).J_pose;
  RC_ASSERT((analytic - numeric).norm() < kNumericJacobianError * (1.0 + numeric.norm()));
}

RC_GTEST_PROP(MotionModel, HasTheCalibrationJacobianOfItsStep, ()) {
  const MotionModel model(utilityCar());
  const MotionInput input = anyInput();
  const Calibration calibration = anyCalibration();
  const Pose2 pose = anyPose();
  const double duration_s = anyNumber(0.001, 1.0);
  const Jacobian numeric = numericJacobian(
      [&](const Eigen::Vector3d& c) {
        return model.step(pose, input, Calibration::fromVector(c), 0.0, duration_s).pose.vector();
      },
      calibration.vector());
  const Jacobian analytic = model.step(pose, input, calibration, 0.0, duration_s).J_calibration;
  RC_ASSERT((analytic - numeric).norm() < kNumericJacobianError * (1.0 + numeric.norm()));
}

/// The covariance that errors of speed and steering give, by numeric derivatives of the velocity.
RC_GTEST_PROP(MotionModel, CarriesEncoderErrorsToTheVelocity, ()) {
  VehicleConfig vehicle = utilityCar();
  vehicle.noise.speed_deviation_relative = 0.0;
  vehicle.noise.lateral_deviation_relative = 0.0;
  vehicle.noise.steering_deviation_relative = 0.05;
  const MotionModel model(vehicle);
  const AckermannInput input = anyAckermannInput();
  const Jacobian J = numericJacobian(
      [&](const Eigen::Vector3d& i) {
        return vectorOf(model.velocity(AckermannInput{0.0, i.x(), i.y()}, Calibration{}));
      },
      {input.speed_mps, input.steering_rad, 0.0});
  const double speed = vehicle.noise.speed_deviation_mps;
  const double steering =
      std::hypot(vehicle.noise.steering_deviation_rad, 0.05 * input.steering_rad);
  const Eigen::Vector3d variances(speed * speed, steering * steering, 0.0);
  const Eigen::Matrix3d expected = J * variances.asDiagonal() * J.transpose();
  const Eigen::Matrix3d covariance =
      model.velocity(input, Calibration{}).covariance(vehicle.noise.correlation_time_s);
  RC_ASSERT((covariance - expected).norm() < 1e-6 * expected.norm());
}

RC_GTEST_PROP(MotionModel, FollowsTheArcThatSmallStraightStepsApproach, ()) {
  const MotionModel model(utilityCar());
  const MotionInput input = anyInput();
  const Pose2 start = anyPose();
  const double duration_s = anyNumber(0.01, 1.0);
  const BodyVelocity v = model.velocity(input, Calibration{});
  const int steps = 2000;
  const double dt = duration_s / steps;
  Pose2 euler = start;
  for (int i = 0; i < steps; ++i) {
    // Heading of the middle of the step: the error is of second order in its length.
    const double yaw = euler.yaw_rad + 0.5 * v.yaw_rate_radps * dt;
    const Eigen::Vector2d moved =
        Pose2{0.0, 0.0, yaw} * Eigen::Vector2d(v.forward_mps * dt, v.lateral_mps * dt);
    euler = {euler.x_m + moved.x(), euler.y_m + moved.y(),
             wrapAngle(euler.yaw_rad + v.yaw_rate_radps * dt)};
  }
  const Pose2 exact = model.step(start, input, Calibration{}, 0.0, duration_s).pose;
  const double distance = std::hypot(v.forward_mps, v.lateral_mps) * duration_s;
  const double turn_of_a_step = v.yaw_rate_radps * dt;
  RC_ASSERT((exact.position() - euler.position()).norm() <
            distance * turn_of_a_step * turn_of_a_step / 20.0 + 1e-11);
  RC_ASSERT(std::abs(wrapAngle(exact.yaw_rad - euler.yaw_rad)) < 1e-11);
}

RC_GTEST_PROP(MotionModel, ComposesSteps, ()) {
  const MotionModel model(utilityCar());
  const MotionInput input = anyInput();
  const Pose2 start = anyPose();
  const double first_s = anyNumber(0.0, 1.0), second_s = anyNumber(0.0, 1.0);
  const Pose2 middle = model.step(start, input, Calibration{}, 0.0, first_s).pose;
  const Pose2 two_steps = model.step(middle, input, Calibration{}, 0.0, second_s).pose;
  const Pose2 one_step = model.step(start, input, Calibration{}, 0.0, first_s + second_s).pose;
  RC_ASSERT((two_steps.position() - one_step.position()).norm() < 1e-11);
  RC_ASSERT(std::abs(wrapAngle(two_steps.yaw_rad - one_step.yaw_rad)) < 1e-13);
}

TEST(MotionModel, MakesTheAxleCentreFasterThanAWheelInsideTheTurn) {
  const VehicleConfig vehicle = utilityCar();  // the encoder is on the left wheel
  const MotionModel model(vehicle);
  const double steering = 0.3, speed = 4.0;
  const double radius = vehicle.ackermann.wheelbase_m / std::tan(steering);
  const double offset = vehicle.ackermann.encoder_offset_left_m;

  const BodyVelocity left = model.velocity(AckermannInput{0.0, speed, steering}, Calibration{});
  EXPECT_NEAR(left.forward_mps, speed * radius / (radius - offset), 1e-12);
  EXPECT_NEAR(left.yaw_rate_radps, left.forward_mps / radius, 1e-12);

  const BodyVelocity right = model.velocity(AckermannInput{0.0, speed, -steering}, Calibration{});
  EXPECT_NEAR(right.forward_mps, speed * radius / (radius + offset), 1e-12);
  EXPECT_NEAR(right.yaw_rate_radps, -right.forward_mps / radius, 1e-12);
}

TEST(MotionModel, DrivesBackwards) {
  const MotionStep step =
      MotionModel(utilityCar())
          .step(Pose2{}, AckermannInput{0.0, -2.0, 0.2}, Calibration{}, 0.0, 0.5);
  EXPECT_LT(step.pose.x_m, 0.0);
  EXPECT_LT(step.pose.yaw_rad, 0.0);
}

TEST(MotionModel, StaysFiniteForSteeringBeyondTheVehicle) {
  const MotionModel model(utilityCar());
  for (const double steering : {-kPi / 2.0, -1.4, 1.3, kPi / 2.0, 100.0}) {
    const MotionStep step =
        model.step(Pose2{}, AckermannInput{0.0, 3.0, steering}, Calibration{}, 0.0, 0.1);
    EXPECT_TRUE(step.pose.vector().allFinite()) << steering;
    EXPECT_TRUE(step.noise.allFinite()) << steering;
  }
}

TEST(MotionModel, RefusesAnEncoderInTheTurningCentre) {
  VehicleConfig vehicle = utilityCar();
  vehicle.ackermann.encoder_offset_left_m =
      vehicle.ackermann.wheelbase_m / std::tan(vehicle.max_steering_rad);
  EXPECT_THROW(MotionModel{vehicle}, ConfigError);
  vehicle.ackermann.encoder_offset_left_m *= -1.0;
  EXPECT_THROW(MotionModel{vehicle}, ConfigError);
}

/// Covariance after `duration_s` in `steps` equal steps, from exact knowledge.
Eigen::Matrix3d covarianceAfter(const MotionModel& model, const MotionInput& input,
                                double duration_s, int steps) {
  Pose2 pose;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  for (int i = 0; i < steps; ++i) {
    const MotionStep step = model.step(pose, input, Calibration{}, 0.0, duration_s / steps);
    P = step.J_pose * P * step.J_pose.transpose() + step.noise;
    pose = step.pose;
  }
  return P;
}

TEST(MotionNoise, IsWhatItsParametersSayAfterASecond) {
  VehicleConfig vehicle;
  vehicle.noise.speed_deviation_mps = 0.05;
  vehicle.noise.speed_deviation_relative = 0.0;
  vehicle.noise.yaw_rate_deviation_radps = 0.02;
  vehicle.noise.yaw_rate_deviation_relative = 0.0;
  vehicle.noise.lateral_deviation_relative = 0.01;
  vehicle.noise.correlation_time_s = 0.2;
  const double speed = 3.0;
  const Eigen::Matrix3d P =
      covarianceAfter(MotionModel(vehicle), TwistInput{0.0, speed, 0.0, 0.0}, 1.0, 1000);
  EXPECT_NEAR(P(0, 0), 2.0 * 0.05 * 0.05 * 0.2, 1e-12);
  EXPECT_NEAR(P(2, 2), 2.0 * 0.02 * 0.02 * 0.2, 1e-12);
  // Side slip, and the integral of the heading's random walk: q * v^2 * T^3 / 3.
  const double slip = 2.0 * 0.01 * 0.01 * speed * speed * 0.2;
  EXPECT_NEAR(P(1, 1), slip + P(2, 2) * speed * speed / 3.0, 1e-9);
}

struct NamedInput {
  const char* name;
  MotionInput input;
};

void PrintTo(const NamedInput& named, std::ostream* stream) { *stream << named.name; }

class MotionNoiseOf : public testing::TestWithParam<NamedInput> {};

TEST_P(MotionNoiseOf, IsTheSameAtEveryRate) {
  const MotionModel model(utilityCar());
  const Eigen::Matrix3d at_20_hz = covarianceAfter(model, GetParam().input, 1.0, 20);
  const Eigen::Matrix3d at_500_hz = covarianceAfter(model, GetParam().input, 1.0, 500);
  EXPECT_LT((at_20_hz - at_500_hz).norm(), 1e-3 * at_500_hz.norm());
}

TEST_P(MotionNoiseOf, IsTheSameInOneShortStepAsInMany) {
  const MotionModel model(utilityCar());
  const Eigen::Matrix3d one = covarianceAfter(model, GetParam().input, 0.01, 1);
  const Eigen::Matrix3d many = covarianceAfter(model, GetParam().input, 0.01, 10);
  EXPECT_LT((one - many).norm(), 1e-3 * many.norm());
}

TEST_P(MotionNoiseOf, IsACovariance) {
  const MotionStep step = MotionModel(utilityCar()).step(Pose2{}, GetParam().input, {}, 0.0, 0.1);
  EXPECT_LT((step.noise - step.noise.transpose()).norm(), 1e-15 * step.noise.norm());
  EXPECT_GE(step.noise.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-18);
}

TEST_P(MotionNoiseOf, IsNothingInNoTime) {
  const MotionStep step = MotionModel(utilityCar()).step(Pose2{}, GetParam().input, {}, 0.0, 0.0);
  EXPECT_EQ(step.noise.norm(), 0.0);
  EXPECT_EQ(step.pose.vector().norm(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, MotionNoiseOf,
    testing::Values(NamedInput{"CarAheadAndLeft", AckermannInput{0.0, 5.0, 0.25}},
                    NamedInput{"CarBackAndRight", AckermannInput{0.0, -2.0, -0.5}},
                    NamedInput{"TwistAheadAndLeft", TwistInput{0.0, 5.0, 0.0, 0.4}},
                    NamedInput{"TwistSideways", TwistInput{0.0, 1.0, -0.5, -1.0}}));

TEST(MotionGap, AddsNothingWhileTheInputIsTrusted) {
  VehicleConfig vehicle = utilityCar();
  const AckermannInput input{0.0, 5.0, 0.1};
  const double hold_s = vehicle.noise.hold_limit_s;
  const MotionModel model(vehicle);
  const Eigen::Matrix3d fresh = model.step(Pose2{}, input, {}, 0.0, 0.1).noise;
  const Eigen::Matrix3d old = model.step(Pose2{}, input, {}, hold_s - 0.11, 0.1).noise;
  EXPECT_EQ(fresh, old);
  const Eigen::Matrix3d too_old = model.step(Pose2{}, input, {}, hold_s, 0.1).noise;
  EXPECT_GT(too_old(0, 0), fresh(0, 0));
  EXPECT_GT(too_old(2, 2), fresh(2, 2));
}

TEST(MotionGap, CoversAVehicleThatAcceleratesUnseen) {
  const VehicleConfig vehicle = utilityCar();
  const MotionModel model(vehicle);
  const double gap_s = 5.0, dt = 0.05;
  const TwistInput input{0.0, 5.0, 0.0, 0.0};
  Pose2 pose;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 100; ++i) {
    const MotionStep step = model.step(pose, input, {}, i * dt, dt);
    P = step.J_pose * P * step.J_pose.transpose() + step.noise;
    pose = step.pose;
  }
  const double unseen_s = gap_s - vehicle.noise.hold_limit_s;
  const double way_m = 0.5 * vehicle.noise.gap_acceleration_mps2 * unseen_s * unseen_s;
  const double deviation_m = std::sqrt(P(0, 0));
  EXPECT_GT(deviation_m, way_m);
  EXPECT_LT(deviation_m, 2.0 * way_m);
}

}  // namespace
}  // namespace hymm::core
