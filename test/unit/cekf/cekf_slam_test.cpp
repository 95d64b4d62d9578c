#include "cekf/cekf_slam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "cekf/observation_model.h"
#include "common/error.h"
#include "simulation/simulation.h"
#include "support/shipped_config.h"

namespace hymm::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

VehicleConfig simulatedVehicle() {
  VehicleConfig vehicle;
  vehicle.ackermann.encoder_offset_left_m = 0.76;
  vehicle.laser = {3.78, 0.5, 0.0};
  return vehicle;
}

/// A stationary robot whose own detector sees three landmarks.
ObservationSet threeLandmarks(double time_s) {
  ObservationSet set;
  set.time_s = time_s;
  const double places[3][2] = {{8.0, 0.4}, {12.0, -0.5}, {6.0, 1.2}};
  for (const auto& place : places) {
    Observation observation;
    observation.range_m = place[0];
    observation.bearing_rad = place[1];
    observation.covariance = Eigen::Vector2d(1e-3, 1e-5).asDiagonal();
    set.observations.push_back(observation);
  }
  return set;
}

CekfSlam stationarySlam(int sets) {
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  for (int i = 0; i < sets; ++i) {
    slam.process(MotionInput{TwistInput{0.5 * i, 0.0, 0.0, 0.0}});
    slam.process(threeLandmarks(0.5 * i + 0.05));
  }
  return slam;
}

TEST(CekfSlam, BringsLandmarksIntoTheStateAfterEnoughSightings) {
  EXPECT_EQ(stationarySlam(2).landmarkCount(), 0U);
  EXPECT_EQ(stationarySlam(3).landmarkCount(), 3U);
  const LandmarkMap map = stationarySlam(10).landmarkMap(30.0);
  ASSERT_EQ(map.landmarks.size(), 3U);
  EXPECT_NEAR(map.landmarks[0].position.x(), 8.0 * std::cos(0.4), 1e-9);
  EXPECT_EQ(map.landmarks[0].observations, 8);  // the promoting one and seven updates
  EXPECT_EQ(map.cross_covariances.size(), 3U);
}

TEST(CekfSlam, TellsWhatChangedSinceItToldLast) {
  CekfSlam slam = stationarySlam(5);
  const LandmarkUpdate first = slam.takeUpdate();
  EXPECT_EQ(first.since_version, 0U);
  EXPECT_EQ(first.changed.size(), 3U);
  EXPECT_TRUE(slam.takeUpdate().changed.empty());
  slam.process(threeLandmarks(10.0));
  const LandmarkUpdate second = slam.takeUpdate();
  EXPECT_EQ(second.since_version, first.version);
  EXPECT_EQ(second.version, slam.mapVersion());
  EXPECT_EQ(second.changed.size(), 3U);
  slam.reset();
  EXPECT_EQ(slam.takeUpdate().removed_ids.size(), 3U);
  EXPECT_EQ(slam.landmarkCount(), 0U);
}

TEST(CekfSlam, HandsOverJointLandmarksAsTheyWereWhenAsked) {
  CekfSlam slam = stationarySlam(10);
  const LandmarkMap map = slam.landmarkMap(30.0);
  const std::vector<int> ids = {map.landmarks[2].id, map.landmarks[0].id};
  JointLandmarks joint;
  ASSERT_TRUE(slam.requestJointLandmarks(ids, [&](JointLandmarks taken) { joint = taken; }));
  EXPECT_EQ(joint.ids, ids);
  EXPECT_EQ(joint.version, map.version);
  EXPECT_EQ(joint.mean.head<2>(), map.landmarks[2].position);
  EXPECT_EQ((joint.covariance.block<2, 2>(2, 2)), map.landmarks[0].covariance);
  EXPECT_EQ((joint.covariance - joint.covariance.transpose()).norm(), 0.0);
  EXPECT_FALSE(slam.requestJointLandmarks({99}, [](const JointLandmarks&) {}));
}

TEST(CekfSlam, RefusesSetsThatAreNotLater) {
  CekfSlam slam = stationarySlam(3);
  const auto outcome = slam.process(threeLandmarks(0.5));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_FALSE(outcome->accepted);
  EXPECT_NE(outcome->reason.find("not later"), std::string::npos);
  EXPECT_EQ(slam.counts().refused_scans, 1U);
}

TEST(CekfSlam, TakesOneScanOfAStampFromEachSensor) {
  CekfSlam slam = stationarySlam(3);
  ObservationSet front = threeLandmarks(5.0), rear = front;
  rear.T_base_sensor = {-0.5, 0.0, kPi};
  EXPECT_TRUE(slam.process(front)->accepted);
  EXPECT_TRUE(slam.process(rear)->accepted);
  EXPECT_FALSE(slam.process(front)->accepted);
  EXPECT_FALSE(slam.process(rear)->accepted);
  EXPECT_EQ(slam.counts().refused_scans, 2U);
  front.time_s = 5.5;
  EXPECT_TRUE(slam.process(front)->accepted);
}

TEST(CekfSlam, RefusesUnusableObservationsAndGoesOn) {
  CekfSlam slam = stationarySlam(4);
  ObservationSet set = threeLandmarks(5.0);
  set.observations[0].range_m = kNan;
  set.observations[1].covariance = Eigen::Matrix2d::Zero();
  const auto outcome = slam.process(set);
  ASSERT_TRUE(outcome && outcome->accepted);
  EXPECT_EQ(slam.counts().refused_observations, 2U);
  EXPECT_EQ(outcome->observations.observations.size(), 1U);
  EXPECT_TRUE(slam.pose().covariance.allFinite());
}

TEST(CekfSlam, RefusesMotionThatIsNotFiniteOrNotLater) {
  CekfSlam slam = stationarySlam(3);
  slam.process(MotionInput{TwistInput{kNan, 0.0, 0.0, 0.0}});
  slam.process(MotionInput{TwistInput{9.0, kNan, 0.0, 0.0}});
  slam.process(MotionInput{TwistInput{0.1, 0.0, 0.0, 0.0}});
  EXPECT_EQ(slam.counts().refused_motion, 3U);
}

TEST(CekfSlam, GrowsUncertainOverAGapOfOdometry) {
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  slam.process(MotionInput{TwistInput{0.0, 2.0, 0.0, 0.0}});
  slam.process(MotionInput{TwistInput{0.1, 2.0, 0.0, 0.0}});
  ObservationSet empty;
  empty.time_s = 0.2;
  const double before = slam.process(empty)->health.position_deviation_m;
  empty.time_s = 5.2;
  const double after = slam.process(empty)->health.position_deviation_m;
  EXPECT_GT(after, before + 1.0);
  EXPECT_EQ(slam.counts().motion_gaps, 1U);
}

TEST(CekfSlam, StartsAnewAfterAClockReset) {
  CekfSlam slam = stationarySlam(5);
  slam.process(ClockReset{0.0});
  EXPECT_EQ(slam.landmarkCount(), 0U);
  EXPECT_EQ(slam.counts().resets, 1U);
  EXPECT_TRUE(slam.process(threeLandmarks(0.05))->accepted);
}

TEST(CekfSlam, KeepsItsStateWhenTheVehicleTeleports) {
  CekfSlam slam = stationarySlam(10);
  ObservationSet elsewhere = threeLandmarks(6.0);
  for (std::size_t i = 0; i < 3; ++i) {
    elsewhere.observations[i].bearing_rad += 2.5;
    elsewhere.observations[i].range_m += 7.0 + 3.0 * static_cast<double>(i);
  }
  const auto outcome = slam.process(elsewhere);
  ASSERT_TRUE(outcome && outcome->accepted);
  EXPECT_EQ(outcome->health.dof, 0);
  EXPECT_EQ(outcome->health.unexplained, 1.0);
  EXPECT_EQ(slam.counts().slips, 0U);
  EXPECT_TRUE(slam.pose().covariance.allFinite());
}

struct Turn {
  std::optional<ScanOutcome> outcome;
  std::size_t slips = 0;
};

/// A robot that knows three landmarks and has turned by `turn_rad` in 0.1 s without its wheels'
/// saying so; its yaw's deviation is 0.02 rad by what they claim.
Turn turnedUnnoticed(double turn_rad, double slip_probability) {
  CekfSlamConfig config;
  config.slip.probability = slip_probability;
  VehicleConfig vehicle;
  vehicle.noise.yaw_rate_deviation_radps = 0.2;
  CekfSlam slam(config, vehicle);
  for (int i = 0; i < 10; ++i) {
    slam.process(MotionInput{TwistInput{0.1 * i, 0.0, 0.0, 0.0}});
    slam.process(threeLandmarks(0.1 * i));
  }
  slam.process(MotionInput{TwistInput{1.0, 0.0, 0.0, 0.0}});
  ObservationSet turned = threeLandmarks(1.0);
  for (Observation& observation : turned.observations) observation.bearing_rad -= turn_rad;
  std::optional<ScanOutcome> outcome = slam.process(turned);
  return {std::move(outcome), slam.counts().slips};
}

TEST(CekfSlam, TakesItsMotionForWorseWhereThatExplainsAScan) {
  const Turn followed = turnedUnnoticed(0.15, 0.001);
  ASSERT_TRUE(followed.outcome);
  EXPECT_EQ(followed.slips, 1U);
  EXPECT_EQ(followed.outcome->health.dof, 6);
  EXPECT_NEAR(followed.outcome->pose.T_map_base.yaw_rad, 0.15, 0.02);
  const Turn lost = turnedUnnoticed(0.15, 0.0);
  ASSERT_TRUE(lost.outcome);
  EXPECT_EQ(lost.slips, 0U);
  EXPECT_EQ(lost.outcome->health.dof, 0);
}

TEST(CekfSlam, TakesNoSlipWhereItsMotionExplainsAScanOrNothingDoes) {
  for (const auto& [turn_rad, dof] : {std::pair(0.03, 6), std::pair(0.6, 0)}) {
    const Turn turn = turnedUnnoticed(turn_rad, 0.001);
    ASSERT_TRUE(turn.outcome);
    EXPECT_EQ(turn.slips, 0U) << turn_rad;
    EXPECT_EQ(turn.outcome->health.dof, dof) << turn_rad;
  }
}

TEST(CekfSlam, FollowsIdentitiesThroughLargeErrors) {
  CekfSlam slam(CekfSlamConfig{}, VehicleConfig{});
  ObservationSet set = threeLandmarks(0.1);
  for (int i = 0; i < 3; ++i) set.observations[static_cast<std::size_t>(i)].identity = 10 + i;
  slam.process(MotionInput{TwistInput{0.0, 0.0, 0.0, 0.0}});
  EXPECT_EQ(slam.process(set)->associations[0].landmark_id, 0);
  // Five seconds without odometry: the vehicle may be anywhere, and has moved a metre.
  set.time_s = 6.0;
  for (Observation& observation : set.observations) observation.range_m -= 0.3;
  const auto outcome = slam.process(set);
  EXPECT_EQ(outcome->health.dof, 6);
  EXPECT_EQ(slam.landmarkCount(), 3U);
}

/// How far a robot has gone round its circle, whose speed changes: at constant speed an error of
/// time looks like one of yaw.
double angleAt(double time_s) { return 0.2 * time_s + 0.1 * (1.0 - std::cos(time_s)); }

/// A robot on a circle of 10 m among landmarks that tell their identity; its sensor has errors
/// that the filter is to find.
LaserCalibration calibrationAfterCircles(const Eigen::Vector3d& truth) {
  VehicleConfig vehicle;
  vehicle.calibration.laser_yaw_deviation_rad = 0.05;
  vehicle.calibration.laser_range_offset_deviation_m = 0.2;
  vehicle.calibration.laser_time_offset_deviation_s = 0.1;
  const Pose2 mounting{1.5, 0.3, 0.0}, true_mounting{1.5, 0.3, truth[0]};
  CekfSlam slam(CekfSlamConfig{}, vehicle);
  for (int step = 1; step <= 1200; ++step) {
    const double time_s = 0.1 * step, angle = angleAt(time_s + truth[2]);
    const double yaw_rate_radps = (angleAt(time_s + 0.1) - angleAt(time_s)) / 0.1;
    slam.process(MotionInput{TwistInput{time_s, 10.0 * yaw_rate_radps, 0.0, yaw_rate_radps}});
    // base_link goes round (0, 10), starting at the origin along x.
    const Pose2 T_map_base{10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle), angle};
    ObservationSet set;
    set.time_s = time_s;
    set.T_base_sensor = mounting;
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector2d landmark(15.0 * std::cos(k), 10.0 + 15.0 * std::sin(k));
      const Eigen::Vector2d z = predictRangeBearing(T_map_base, true_mounting, landmark).value;
      Observation observation;
      observation.range_m = z[0] + truth[1];
      observation.bearing_rad = z[1];
      observation.covariance = Eigen::Vector2d(1e-4, 1e-6).asDiagonal();
      observation.identity = k;
      set.observations.push_back(observation);
    }
    slam.process(set);
  }
  return slam.laserCalibration();
}

TEST(CekfSlam, FindsErrorsOfTheLasersYawRangeAndTime) {
  const Eigen::Vector3d truth(0.02, 0.05, -0.04);
  const LaserCalibration found = calibrationAfterCircles(truth);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(found.mean[k] - truth[k]), 3.0 * found.deviation[k]) << k;
  }
  EXPECT_LT(found.deviation[0], 0.01);
  EXPECT_LT(found.deviation[1], 0.01);
  EXPECT_LT(found.deviation[2], 0.01);
}

/// Scans of a simulated world through the filter; position error against truth.
class SimulatedRun {
 public:
  SimulatedRun(const std::string& world, unsigned seed, bool gps,
               CekfSlam::GlobalUpdates global_updates = CekfSlam::GlobalUpdates::kInline) {
    SimulationConfig simulation_config;
    simulation_config.world.name = world;
    simulation_config.drive.duration_s = 90.0;
    VehicleConfig vehicle = simulatedVehicle();
    Simulation simulation(simulation_config, vehicle, seed);
    CekfSlamConfig config;
    config.gps.enabled = gps;
    config.perception.trunks.enabled = world != "car_park";
    config.perception.reflectors.enabled = world == "car_park";
    CekfSlam slam(config, vehicle, global_updates);
    while (const auto simulated = simulation.next()) {
      const auto outcome = slam.process(simulated->event);
      if (!outcome || !outcome->accepted) continue;
      worst_error_m =
          std::max(worst_error_m,
                   (outcome->pose.T_map_base.position() - simulated->T_map_base.position()).norm());
      poses.push_back(outcome->pose.T_map_base.vector());
    }
    landmarks = slam.landmarkCount();
    gps_used = slam.counts().gps_used;
  }

  double worst_error_m = 0.0;
  std::size_t landmarks = 0;
  std::size_t gps_used = 0;
  std::vector<Eigen::Vector3d> poses;
};

TEST(CekfSlam, TracksASimulatedPark) {
  const SimulatedRun run("park", 3, false);
  EXPECT_LT(run.worst_error_m, 0.4);  // 0.29 measured
  EXPECT_GT(run.landmarks, 30U);
  EXPECT_GT(run.poses.size(), 400U);
}

TEST(CekfSlam, TracksASimulatedCarParkByReflectors) {
  const SimulatedRun run("car_park", 3, false);
  EXPECT_LT(run.worst_error_m, 0.2);  // 0.12 measured
  EXPECT_GT(run.landmarks, 20U);
}

TEST(CekfSlam, BoundsItsDriftByGps) {
  const SimulatedRun run("park", 4, true), without("park", 4, false);
  EXPECT_GT(run.gps_used, 10U);
  EXPECT_LT(run.worst_error_m, 1.0);  // 0.75 measured, 2.7 without GPS
  EXPECT_LT(run.worst_error_m, without.worst_error_m);
}

TEST(CekfSlam, RepeatsItself) {
  const SimulatedRun first("park", 5, false), second("park", 5, false);
  EXPECT_EQ(first.poses, second.poses);
}

TEST(CekfSlam, DrivesTheSameWithTheWorkerInTheBackground) {
  const SimulatedRun inline_run("park", 5, false);
  const SimulatedRun live("park", 5, false, CekfSlam::GlobalUpdates::kBackground);
  ASSERT_EQ(live.poses.size(), inline_run.poses.size());
  EXPECT_EQ(live.landmarks, inline_run.landmarks);
  double farthest = 0.0;
  for (std::size_t k = 0; k < live.poses.size(); ++k) {
    farthest = std::max(farthest, (live.poses[k] - inline_run.poses[k]).norm());
  }
  EXPECT_LT(farthest, 1e-6);
}

TEST(CekfSlamConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("cekf_slam", CekfSlamConfig());
}

}  // namespace
}  // namespace hymm::core
