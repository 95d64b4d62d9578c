#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "pipeline/sensor_merger.h"
#include "simulation/simulation.h"

namespace hymm::core {
namespace {

/// Two laps of the park, of which the recording has lost some seconds; the vehicle drove on.
class DriveWithGap {
 public:
  DriveWithGap(double from_s, double to_s, std::uint64_t seed) {
    SimulationConfig world;
    world.drive.laps = 2;
    world.gps.enabled = false;
    Simulation simulation(world, simulatedCar(), seed);
    CekfSlam slam(CekfSlamConfig{}, simulatedCar());
    SensorMerger merger({});
    double begin_s = -1.0;
    while (auto simulated = simulation.next()) {
      const double time_s = timeOf(simulated->event);
      if (begin_s < 0.0) begin_s = time_s;
      if (std::holds_alternative<ScanEvent>(simulated->event)) {
        truth_[time_s] = simulated->T_map_base;
      }
      if (time_s - begin_s > from_s && time_s - begin_s < to_s) continue;
      merger.push(simulated->event);
      for (const SensorEvent& event : merger.popReady()) {
        const auto outcome = slam.process(event);
        if (outcome && outcome->accepted) take(*outcome);
      }
    }
    counts_ = slam.counts();
    for (const LandmarkEstimate& landmark : mapOf(slam).landmarks) {
      double nearest_m = 1e9;
      for (const TrueLandmark& there : simulation.landmarks()) {
        nearest_m = std::min(nearest_m, (there.position - landmark.position).norm());
      }
      if (nearest_m > 1.0) ++false_landmarks_;
    }
  }

  double errorAtEnd_m() const { return error_m_; }
  double largestError_m() const { return largest_error_m_; }
  const CekfSlam::Counts& counts() const { return counts_; }
  int falseLandmarks() const { return false_landmarks_; }

 private:
  static LandmarkMap mapOf(CekfSlam& slam) {
    LandmarkMap map;
    slam.requestMap(0.0, [&map](LandmarkMap told) { map = std::move(told); });
    return map;
  }

  void take(const ScanOutcome& outcome) {
    const Pose2& truth = truth_.at(outcome.pose.time_s);
    error_m_ = (outcome.pose.T_map_base.position() - truth.position()).norm();
    largest_error_m_ = std::max(largest_error_m_, error_m_);
  }

  std::map<double, Pose2> truth_;
  double error_m_ = 0.0, largest_error_m_ = 0.0;
  int false_landmarks_ = 0;
  CekfSlam::Counts counts_;
};

TEST(GapInARecording, ThePlaceIsFoundAmongTheLandmarks) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const DriveWithGap whole(0.0, 0.0, seed), gap(150.0, 165.0, seed);
    EXPECT_EQ(whole.counts().places_found, 0U) << seed;
    EXPECT_EQ(whole.counts().scans_without_place, 0U) << seed;
    EXPECT_GE(gap.counts().places_found, 1U) << seed;
    EXPECT_LT(gap.errorAtEnd_m(), whole.errorAtEnd_m() + 0.3) << seed;
    EXPECT_LE(gap.falseLandmarks(), whole.falseLandmarks() + 2) << seed;
  }
}

TEST(GapInARecording, NothingIsMappedBeforeThePlaceIsKnown) {
  // In the first lap the vehicle comes out of the gap where it has never been.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const DriveWithGap whole(0.0, 0.0, seed), gap(40.0, 55.0, seed);
    EXPECT_GT(gap.counts().scans_without_place, 100U) << seed;
    EXPECT_GE(gap.counts().places_found, 1U) << seed;
    EXPECT_LT(gap.errorAtEnd_m(), whole.errorAtEnd_m() + 0.3) << seed;
    EXPECT_LE(gap.falseLandmarks(), whole.falseLandmarks() + 2) << seed;
  }
}

/// How far off the way is of a drive whose first seconds have no motion, though the vehicle drives,
/// after them.
double errorWithMotionFrom(double from_s, bool with_scans_before, CekfSlam::Counts& counts) {
  SimulationConfig world;
  world.drive.duration_s = 40.0;
  world.gps.enabled = false;
  Simulation simulation(world, simulatedCar(), 1);
  CekfSlam slam(CekfSlamConfig{}, simulatedCar());
  SensorMerger merger({});
  std::map<double, Pose2> truth;
  double begin_s = -1.0;
  std::optional<std::pair<Pose2, Pose2>> first, last;  // estimate and truth, once motion has come
  while (auto simulated = simulation.next()) {
    const double time_s = timeOf(simulated->event);
    if (begin_s < 0.0) begin_s = time_s;
    const bool is_motion = std::holds_alternative<MotionInput>(simulated->event);
    if ((is_motion || !with_scans_before) && time_s - begin_s < from_s) continue;
    if (std::holds_alternative<ScanEvent>(simulated->event)) {
      truth[time_s] = simulated->T_map_base;
    }
    merger.push(simulated->event);
    for (const SensorEvent& event : merger.popReady()) {
      const auto outcome = slam.process(event);
      if (!outcome || !outcome->accepted || outcome->pose.time_s - begin_s < from_s) continue;
      last = {outcome->pose.T_map_base, truth.at(outcome->pose.time_s)};
      if (!first) first = last;
    }
  }
  counts = slam.counts();
  const Pose2 way = inverse(first->first) * last->first;
  const Pose2 true_way = inverse(first->second) * last->second;
  return (way.position() - true_way.position()).norm();
}

TEST(MotionThatComesLate, TheMapBeginsWithIt) {
  CekfSlam::Counts without, with;
  const double without_m = errorWithMotionFrom(5.0, false, without);
  const double with_m = errorWithMotionFrom(5.0, true, with);
  EXPECT_LE(without.scans_without_motion, 1U);
  EXPECT_GT(with.scans_without_motion, 20U);
  EXPECT_GE(with.refused_scans, with.scans_without_motion - 1);
  EXPECT_LT(without_m, 2.0);
  EXPECT_NEAR(with_m, without_m, 1e-6);
}

}  // namespace
}  // namespace hymm::core
