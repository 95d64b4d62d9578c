#include "cekf/observation_model.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr double kStep = 1e-6;
constexpr double kNumeric = 1e-7;

const Pose2 kBase{3.0, -2.0, 0.7};
const Pose2 kSensor{3.78, 0.5, 0.1};
const Vector2d kLandmark{15.0, 8.0};

Eigen::Vector2d wrapped(Eigen::Vector2d z) { return {z.x(), wrapAngle(z.y())}; }

Pose2 moved(const Pose2& pose, int axis, double by) {
  Eigen::Vector3d v = pose.vector();
  v[axis] += by;
  return Pose2::fromVector(v);
}

TEST(ObservationModel, MeasuresTheSensorsFrame) {
  const RangeBearing z = predictRangeBearing({0.0, 0.0, kPi / 2.0}, {2.0, 1.0, 0.0}, {-1.0, 7.0});
  EXPECT_NEAR(z.value[0], 5.0, 1e-12);
  EXPECT_NEAR(z.value[1], 0.0, 1e-12);
}

TEST(ObservationModel, HasJacobiansOfTheMeasurement) {
  const RangeBearing z = predictRangeBearing(kBase, kSensor, kLandmark);
  for (int axis = 0; axis < 3; ++axis) {
    const auto ahead = predictRangeBearing(moved(kBase, axis, kStep), kSensor, kLandmark).value;
    const auto behind = predictRangeBearing(moved(kBase, axis, -kStep), kSensor, kLandmark).value;
    EXPECT_LT((wrapped(ahead - behind) / (2.0 * kStep) - z.H_pose.col(axis)).norm(), kNumeric);
  }
  for (int axis = 0; axis < 2; ++axis) {
    const Vector2d step = kStep * Vector2d::Unit(axis);
    const auto ahead = predictRangeBearing(kBase, kSensor, kLandmark + step).value;
    const auto behind = predictRangeBearing(kBase, kSensor, kLandmark - step).value;
    EXPECT_LT((wrapped(ahead - behind) / (2.0 * kStep) - z.H_landmark.col(axis)).norm(), kNumeric);
  }
}

TEST(ObservationModel, LocatesWhatItMeasures) {
  const RangeBearing z = predictRangeBearing(kBase, kSensor, kLandmark);
  const LocatedLandmark located = locateLandmark(kBase, kSensor, z.value[0], z.value[1]);
  EXPECT_LT((located.position - kLandmark).norm(), 1e-12);
}

TEST(ObservationModel, HasJacobiansOfTheLocation) {
  const double r = 12.0, b = -0.4;
  const LocatedLandmark located = locateLandmark(kBase, kSensor, r, b);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector2d difference = locateLandmark(moved(kBase, axis, kStep), kSensor, r, b).position -
                                locateLandmark(moved(kBase, axis, -kStep), kSensor, r, b).position;
    EXPECT_LT((difference / (2.0 * kStep) - located.G_pose.col(axis)).norm(), kNumeric);
  }
  const Vector2d by_range = locateLandmark(kBase, kSensor, r + kStep, b).position -
                            locateLandmark(kBase, kSensor, r - kStep, b).position;
  const Vector2d by_bearing = locateLandmark(kBase, kSensor, r, b + kStep).position -
                              locateLandmark(kBase, kSensor, r, b - kStep).position;
  EXPECT_LT((by_range / (2.0 * kStep) - located.G_measurement.col(0)).norm(), kNumeric);
  EXPECT_LT((by_bearing / (2.0 * kStep) - located.G_measurement.col(1)).norm(), kNumeric);
}

TEST(ObservationModel, HasJacobiansByTheRangeOffset) {
  SensorPlacement sensor;
  sensor.T_base_sensor = kSensor;
  sensor.range_offset_state = 5;
  const RangeBearing z = predictRangeBearing(kBase, kSensor, kLandmark);
  EXPECT_EQ(vehicleJacobian(z, sensor, 6).col(5), Vector2d(1.0, 0.0));
  const LocatedLandmark located = locateLandmark(kBase, kSensor, 9.0, 0.3);
  const Vector2d d_location = (locateLandmark(kBase, kSensor, 9.0 - kStep, 0.3).position -
                               locateLandmark(kBase, kSensor, 9.0 + kStep, 0.3).position) /
                              (2.0 * kStep);
  EXPECT_LT((vehicleJacobian(located, sensor, 6).col(5) - d_location).norm(), kNumeric);
}

TEST(ObservationModel, HasJacobiansByTheMountingsYaw) {
  SensorPlacement sensor;
  sensor.T_base_sensor = kSensor;
  sensor.yaw_state = 5;
  Pose2 turned_left = kSensor, turned_right = kSensor;
  turned_left.yaw_rad += kStep;
  turned_right.yaw_rad -= kStep;
  const RangeBearing z = predictRangeBearing(kBase, kSensor, kLandmark);
  const Vector2d d_measurement = (predictRangeBearing(kBase, turned_left, kLandmark).value -
                                  predictRangeBearing(kBase, turned_right, kLandmark).value) /
                                 (2.0 * kStep);
  EXPECT_LT((vehicleJacobian(z, sensor, 6).col(5) - d_measurement).norm(), kNumeric);
  const LocatedLandmark located = locateLandmark(kBase, kSensor, 9.0, 0.3);
  const Vector2d d_location = (locateLandmark(kBase, turned_left, 9.0, 0.3).position -
                               locateLandmark(kBase, turned_right, 9.0, 0.3).position) /
                              (2.0 * kStep);
  EXPECT_LT((vehicleJacobian(located, sensor, 6).col(5) - d_location).norm(), kNumeric);
}

TEST(ObservationModel, StaysFiniteAtTheSensorItself) {
  const RangeBearing z = predictRangeBearing({}, {}, {0.0, 0.0});
  EXPECT_TRUE(z.value.allFinite());
  EXPECT_TRUE(z.H_landmark.allFinite());
}

}  // namespace
}  // namespace hymm::core
