#include "cekf/resumption.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "recorded_loop.h"

namespace hymm::core {
namespace {

TEST(Resumption, VehicleAmongLandmarksIsOneGaussian) {
  const Recording recording = record(180);
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, kEnd_s);
  const Joint joint = jointOf(slam);
  ASSERT_GT(joint.ids.size(), 20U);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(joint.covariance);
  EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9 * solver.eigenvalues().maxCoeff());
  EXPECT_GT(joint.covariance.topRightCorner(3, 2 * 20).norm(), 0.0);
  EXPECT_FALSE(slam.requestVehicleAmongLandmarks({9999}, [](const VehicleAmongLandmarks&) {}));
}

TEST(Resumption, WaitsWithThePoseCarriedOnByTheMotion) {
  const Recording recording = record(180);
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, kT0_s);
  ASSERT_TRUE(slam.suspend(kT0_s));
  const Joint before = jointOf(slam);
  std::size_t waited = 0;
  for (const SensorEvent& event : recording.events) {
    if (timeOf(event) <= kT0_s || timeOf(event) > kEnd_s) continue;
    const auto outcome = slam.process(event);
    if (!outcome) continue;
    EXPECT_TRUE(outcome->accepted && outcome->suspended);
    EXPECT_FALSE(outcome->observations.observations.empty());
    EXPECT_EQ(outcome->health.dof, 0);
    ++waited;
  }
  EXPECT_EQ(waited, 28U);
  EXPECT_EQ(jointOf(slam).mean, before.mean);
  EXPECT_EQ(slam.pose().time_s, kEnd_s);
  EXPECT_LT(
      (slam.pose().T_map_base.position() - recording.truth.back().T_map_base.position()).norm(),
      3.0);
  EXPECT_GT(slam.pose().covariance(0, 0), before.covariance(0, 0));
}

std::vector<PlaceAtScan> pathFrom(const Recording& recording, double from_s, double x_off_m = 0.0) {
  std::vector<PlaceAtScan> path;
  for (PlaceAtScan place : recording.truth) {
    place.T_map_base.x_m += x_off_m;
    if (place.time_s >= from_s && place.time_s <= kEnd_s) path.push_back(place);
  }
  return path;
}

TEST(Resumption, ClosesAsAFilterThatKnowsTheAssociations) {
  const Recording recording = record(200, true);  // the closing itself does not look at identities
  const double close_s = 84.0;
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, kT0_s);
  ASSERT_TRUE(slam.suspend(kT0_s));
  feed(slam, recording, kT0_s, kEnd_s);
  const Resumption outcome = slam.resume(kT0_s, pathFrom(recording, close_s));
  ASSERT_TRUE(outcome.accepted()) << outcome.reason;
  EXPECT_EQ(outcome.closed_s, close_s);
  EXPECT_GE(outcome.closing_pairs, 3);
  EXPECT_EQ(outcome.scans, 28U);
  EXPECT_FALSE(slam.isSuspended());

  CekfSlam knowing = newSlam(0.0);
  for (const SensorEvent& event : recording.events) {
    const bool is_scan = std::holds_alternative<ObservationSet>(event);
    if (timeOf(event) > kEnd_s || (is_scan && timeOf(event) > kT0_s && timeOf(event) < close_s)) {
      continue;
    }
    knowing.process(event);
  }
  const Joint expected = jointOf(knowing), is = jointOf(slam);
  ASSERT_EQ(is.ids.size(), expected.ids.size());
  EXPECT_LT(difference({expected.ids, is.mean, is.covariance}, expected), 0.05);
}

TEST(Resumption, ARefusalLeavesEverythingAsItWas) {
  const Recording recording = record(200);
  CekfSlam slam = newSlam(), twin = newSlam();
  for (CekfSlam* each : {&slam, &twin}) {
    feed(*each, recording, -1.0, kT0_s);
    ASSERT_TRUE(each->suspend(kT0_s));
    feed(*each, recording, kT0_s, kEnd_s);
  }
  slam.takeUpdate();
  twin.takeUpdate();
  const auto nothing_there = slam.resume(kT0_s, pathFrom(recording, 84.0, 500.0));
  EXPECT_EQ(nothing_there.refusal, Resumption::Refusal::kNothingPlain);
  EXPECT_EQ(slam.resume(kT0_s, {}).refusal, Resumption::Refusal::kUnusablePath);
  EXPECT_EQ(slam.resume(kT0_s - 100.0, pathFrom(recording, 84.0)).refusal,
            Resumption::Refusal::kNotKept);
  EXPECT_EQ(slam.counts().refused_resumptions, 3U);
  EXPECT_TRUE(slam.isSuspended());
  EXPECT_EQ(slam.pose().T_map_base.vector(), twin.pose().T_map_base.vector());
  EXPECT_EQ(jointOf(slam).covariance, jointOf(twin).covariance);
  EXPECT_TRUE(slam.takeUpdate().changed.empty());

  const auto path = pathFrom(recording, 84.0);
  EXPECT_TRUE(slam.resume(kT0_s, path).accepted());
  EXPECT_TRUE(twin.resume(kT0_s, path).accepted());
  EXPECT_EQ(jointOf(slam).mean, jointOf(twin).mean);
  EXPECT_EQ(jointOf(slam).covariance, jointOf(twin).covariance);
}

TEST(Resumption, RefusesWhatContradictsTheCovariances) {
  Recording recording = record(100);
  for (SensorEvent& event : recording.events) {
    auto* set = std::get_if<ObservationSet>(&event);
    if (set != nullptr && set->time_s == 37.0) set->observations.front().range_m += 0.5;
  }
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, 40.0);
  ASSERT_TRUE(slam.suspend(36.0));
  const Resumption outcome = slam.resume(36.0, {recording.truth[73]});
  ASSERT_EQ(recording.truth[73].time_s, 37.0);
  EXPECT_EQ(outcome.refusal, Resumption::Refusal::kContradiction) << outcome.reason;
  EXPECT_TRUE(slam.isSuspended());
  EXPECT_TRUE(slam.resume(36.0, {recording.truth[74]}).accepted());
}

SensorEvent shifted(const SensorEvent& event, double by_s) {
  if (const auto* set = std::get_if<ObservationSet>(&event)) {
    ObservationSet later = *set;
    later.time_s += by_s;
    return later;
  }
  TwistInput later = std::get<TwistInput>(std::get<MotionInput>(event));  // a drive with odometry
  later.time_s += by_s;
  return MotionInput(later);
}

TEST(Resumption, TakesOverAPlaceThatTheVehicleWasCarriedTo) {
  const Recording recording = record(200);
  constexpr double kThere_s = 20.0, kDriven_s = 4.0;
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, kEnd_s);
  ASSERT_TRUE(slam.suspend(kEnd_s));
  const auto is_driven = [&](double time_s) {
    return time_s > kThere_s && time_s <= kThere_s + kDriven_s;
  };
  for (const SensorEvent& event : recording.events) {
    if (is_driven(timeOf(event))) slam.process(shifted(event, kEnd_s - kThere_s));
  }
  std::vector<PlaceAtScan> path;
  for (PlaceAtScan place : recording.truth) {
    if (!is_driven(place.time_s)) continue;
    place.time_s += kEnd_s - kThere_s;
    path.push_back(place);
  }
  EXPECT_FALSE(slam.resume(kEnd_s, path).accepted());
  const Resumption outcome = slam.resumeElsewhere(kEnd_s, path);
  ASSERT_TRUE(outcome.accepted()) << outcome.reason;
  const Eigen::Vector2d found = slam.pose().T_map_base.position();
  EXPECT_LT((found - path.back().T_map_base.position()).norm(), 0.5);
}

TEST(Resumption, WithoutClosingGoesOnByDeadReckoning) {
  const Recording recording = record(200);
  CekfSlam slam = newSlam();
  feed(slam, recording, -1.0, kT0_s);
  const Joint at_T0 = jointOf(slam);
  feed(slam, recording, kT0_s, kT0_s + 4.0);
  const Resumption outcome = slam.resumeWithoutClosing(kT0_s);
  ASSERT_TRUE(outcome.accepted()) << outcome.reason;
  EXPECT_EQ(outcome.scans, 8U);
  const Joint now = jointOf(slam);
  EXPECT_EQ(now.mean.tail(now.mean.size() - 3), at_T0.mean.tail(at_T0.mean.size() - 3));
  EXPECT_GT(now.covariance(2, 2), at_T0.covariance(2, 2));
  EXPECT_EQ(slam.pose().time_s, kT0_s + 4.0);
  feed(slam, recording, kT0_s + 4.0, kEnd_s);
  EXPECT_GT(slam.counts().associated, 0U);
}

TEST(Resumption, GivesOutNoIdTwice) {
  const Recording recording = record(200);
  CekfSlam slam = newSlam(kRing_s);
  feed(slam, recording, -1.0, 40.0);
  int highest = -1;
  for (const auto& landmark : slam.landmarkMap(0.0).landmarks) {
    highest = std::max(highest, landmark.id);
  }
  const std::size_t count = slam.landmarkCount();
  ASSERT_TRUE(slam.resumeWithoutClosing(36.0).accepted());
  ASSERT_LT(slam.landmarkCount(), count);
  feed(slam, recording, 40.0, 60.0);
  std::vector<int> fresh;
  for (const auto& landmark : slam.landmarkMap(0.0).landmarks) {
    if (landmark.id > highest) fresh.push_back(landmark.id);
  }
  EXPECT_FALSE(fresh.empty());
  for (const int removed : slam.takeUpdate().removed_ids) EXPECT_LE(removed, highest);
}

}  // namespace
}  // namespace hymm::core
