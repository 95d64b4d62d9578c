#include <cmath>
#include <random>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "common/error.h"
#include "simulation/simulation.h"

/// What the filter saves, and how it goes on from there.
namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kName = "The saved map";

struct Drive {
  VehicleConfig vehicle = simulatedCar();
  CekfSlamConfig config;
  std::vector<SimulatedEvent> events;
};

/// A lap of the park with a laser, GPS fixes and a calibration to be found.
Drive drive(bool gps = false, double duration_s = 60.0, int laps = 1) {
  Drive drive;
  drive.config.gps.enabled = gps;
  SimulationConfig config;
  config.world.name = "park";
  config.drive.laps = laps;
  config.drive.duration_s = duration_s;
  config.gps.enabled = gps;
  Simulation simulation(config, drive.vehicle, 3);
  while (auto event = simulation.next()) drive.events.push_back(std::move(*event));
  return drive;
}

void process(CekfSlam& slam, const Drive& drive, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) slam.process(drive.events[i].event);
}

double errorAt(const CekfSlam& slam, const SimulatedEvent& event) {
  return (slam.pose().T_map_base.position() - event.T_map_base.position()).norm();
}

class SavedFilter : public testing::TestWithParam<bool> {};

TEST_P(SavedFilter, GoesOnToTheBitAsIfItHadNeverStopped) {
  const Drive drive = core::drive(GetParam());
  for (const double share : {0.02, 0.37, 0.71}) {
    const auto half = static_cast<std::size_t>(share * static_cast<double>(drive.events.size()));
    CekfSlam whole(drive.config, drive.vehicle), before(drive.config, drive.vehicle);
    process(whole, drive, 0, half);
    process(before, drive, 0, half);
    const std::string state = before.saveState();
    CekfSlam after(drive.config, drive.vehicle);
    after.loadState(state, kName, MapUse::kExtend);
    EXPECT_EQ(after.saveState(), state);
    // Updates that nobody asked for are not part of what goes on.
    whole.takeUpdate();
    after.takeUpdate();
    process(whole, drive, half, drive.events.size());
    process(after, drive, half, drive.events.size());
    ASSERT_GT(whole.landmarkCount(), 20U);
    EXPECT_TRUE(after.saveState() == whole.saveState()) << "split at " << share;
    EXPECT_EQ(after.pose().T_map_base.vector(), whole.pose().T_map_base.vector());
  }
}

TEST_P(SavedFilter, IsTheSameWhetherItsWorkerHasAThreadOrNot) {
  const Drive drive = core::drive(GetParam(), 20.0);
  CekfSlam slam(drive.config, drive.vehicle, CekfSlam::GlobalUpdates::kBackground);
  process(slam, drive, 0, drive.events.size());
  const std::string state = slam.saveState();
  CekfSlam after(drive.config, drive.vehicle, CekfSlam::GlobalUpdates::kBackground);
  after.loadState(state, kName, MapUse::kExtend);
  EXPECT_EQ(after.saveState(), state);
  EXPECT_EQ(after.landmarkCount(), slam.landmarkCount());
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutGps, SavedFilter, testing::Bool());

TEST(SavedFilter, SavingChangesNothing) {
  const Drive drive = core::drive(false, 30.0);
  CekfSlam saved(drive.config, drive.vehicle), other(drive.config, drive.vehicle);
  for (std::size_t i = 0; i < drive.events.size(); ++i) {
    saved.process(drive.events[i].event);
    other.process(drive.events[i].event);
    if (i % 100 == 0) saved.saveState();
  }
  EXPECT_TRUE(saved.saveState() == other.saveState());
}

/// While scans can be gone back to, the last global update is in force, but not carried out.
TEST(SavedFilter, HoldsWhatAGlobalUpdateSaysThatIsHeldBack) {
  const Drive drive = core::drive(true);
  int held = 0;
  for (std::size_t end = 500; end <= drive.events.size(); end += 300) {
    CekfSlam slam(drive.config, drive.vehicle), after(drive.config, drive.vehicle);
    slam.keepLocalStates(6.0);
    process(slam, drive, 0, end);
    held += slam.isGlobalUpdatePending() ? 1 : 0;
    const std::string state = slam.saveState();
    EXPECT_TRUE(slam.saveState() == state);
    after.loadState(state, kName, MapUse::kExtend);
    EXPECT_FALSE(after.isGlobalUpdatePending());
    EXPECT_EQ(after.pose().T_map_base.vector(), slam.pose().T_map_base.vector());
    EXPECT_EQ(after.pose().covariance, slam.pose().covariance);
    const LandmarkMap expected = slam.landmarkMap(1000.0), found = after.landmarkMap(1000.0);
    ASSERT_EQ(found.landmarks.size(), expected.landmarks.size());
    for (std::size_t i = 0; i < found.landmarks.size(); ++i) {
      EXPECT_EQ(found.landmarks[i].id, expected.landmarks[i].id);
      const LandmarkEstimate &mine = found.landmarks[i], &theirs = expected.landmarks[i];
      EXPECT_LT((mine.position - theirs.position).norm(), 1e-13);  // sums in another order
      EXPECT_TRUE(mine.covariance.isApprox(theirs.covariance, 1e-13));
    }
  }
  EXPECT_GT(held, 2);
}

TEST(SavedFilter, LocalisesInAMapThatStaysAsItIs) {
  const Drive drive = core::drive(false, 0.0, 2);
  const std::size_t half = drive.events.size() / 2;
  CekfSlam mapper(drive.config, drive.vehicle), fixed(drive.config, drive.vehicle);
  process(mapper, drive, 0, half);
  fixed.loadState(mapper.saveState(), kName, MapUse::kLocalise);
  const LandmarkMap before = fixed.landmarkMap(1000.0);
  double worst_m = 0.0;
  int normalised_count = 0;
  double normalised = 0.0;
  for (std::size_t i = half; i < drive.events.size(); ++i) {
    const auto outcome = fixed.process(drive.events[i].event);
    if (!outcome || !outcome->accepted) continue;
    const Pose2& truth = drive.events[i].T_map_base;
    const Eigen::Vector2d error = outcome->pose.T_map_base.position() - truth.position();
    worst_m = std::max(worst_m, error.norm());
    normalised += error.dot(outcome->pose.covariance.topLeftCorner<2, 2>().inverse() * error);
    ++normalised_count;
  }
  const LandmarkMap after = fixed.landmarkMap(1000.0);
  ASSERT_EQ(after.landmarks.size(), before.landmarks.size());
  for (std::size_t i = 0; i < after.landmarks.size(); ++i) {
    // To rounding: what the interval before the save says of passive landmarks is added when they
    // are looked at, until a global update adds it for good.
    EXPECT_LT((after.landmarks[i].position - before.landmarks[i].position).norm(), 1e-13);
    EXPECT_TRUE(after.landmarks[i].covariance.isApprox(before.landmarks[i].covariance, 1e-13));
    EXPECT_EQ(after.landmarks[i].observations, before.landmarks[i].observations);
  }
  ASSERT_EQ(after.cross_covariances.size(), before.cross_covariances.size());
  for (std::size_t i = 0; i < after.cross_covariances.size(); ++i) {
    const Eigen::Matrix2d change =
        after.cross_covariances[i].block - before.cross_covariances[i].block;
    EXPECT_LT(change.norm(), 1e-14);
  }
  EXPECT_LT(worst_m, 0.5);
  // Two degrees of freedom: a mean of 2 is what the covariance promises. Errors of the map persist,
  // so a run counts as few independent draws.
  EXPECT_LT(normalised / normalised_count, 6.0);
}

TEST(SavedFilter, BeginsASessionWhereTheVehicleStoodIfTheClockJumps) {
  const Drive drive = core::drive(false, 40.0);
  CekfSlam mapper(drive.config, drive.vehicle);
  process(mapper, drive, 0, drive.events.size());
  const std::string state = mapper.saveState();
  const Pose2 stood = mapper.pose().T_map_base;
  for (const double jump_s : {86400.0, -30.0}) {
    CekfSlam slam(drive.config, drive.vehicle);
    slam.loadState(state, kName, MapUse::kExtend);
    const double now_s = mapper.pose().time_s + jump_s;
    slam.process(MotionInput{AckermannInput{now_s, 3.0, 0.1}});
    EXPECT_EQ(slam.pose().T_map_base.vector(), stood.vector()) << jump_s;
    slam.process(MotionInput{AckermannInput{now_s + 0.1, 3.0, 0.1}});
    EXPECT_NEAR((slam.pose().T_map_base.position() - stood.position()).norm(), 0.3, 0.05) << jump_s;
    EXPECT_EQ(slam.counts().motion_gaps, 0U);
  }
}

TEST(SavedFilter, GoesOnFromWhereTheVehicleIsPlaced) {
  const Drive drive = core::drive(false, 0.0, 1);
  CekfSlam mapper(drive.config, drive.vehicle);
  process(mapper, drive, 0, drive.events.size());
  CekfSlam slam(drive.config, drive.vehicle);
  slam.loadState(mapper.saveState(), kName, MapUse::kLocalise);
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.04, 0.04, 0.0025).asDiagonal();
  slam.placeVehicle({0.2, -0.1, 0.02}, covariance);
  EXPECT_EQ(slam.pose().T_map_base.vector(), Eigen::Vector3d(0.2, -0.1, 0.02));
  EXPECT_EQ(slam.pose().covariance, covariance);
  // The same drive once more, from its begin.
  process(slam, drive, 0, drive.events.size() / 3);
  EXPECT_LT(errorAt(slam, drive.events[drive.events.size() / 3 - 1]), 0.3);
}

TEST(SavedFilter, LoadingIsAResetWithAVersionThatGrows) {
  const Drive drive = core::drive(false, 20.0);
  CekfSlam slam(drive.config, drive.vehicle);
  process(slam, drive, 0, drive.events.size() / 2);
  const std::string state = slam.saveState();
  process(slam, drive, drive.events.size() / 2, drive.events.size());
  const std::uint64_t version = slam.mapVersion();
  slam.loadState(state, kName, MapUse::kExtend);
  EXPECT_EQ(slam.mapVersion(), version + 1);
  EXPECT_EQ(slam.counts().resets, 1U);
}

TEST(SavedFilter, OfAnotherConfigurationIsRefusedAndNothingTouched) {
  const Drive drive = core::drive(false, 20.0);
  CekfSlam mapper(drive.config, drive.vehicle);
  process(mapper, drive, 0, drive.events.size());
  const std::string state = mapper.saveState();
  CekfSlamConfig with_gps = drive.config;
  with_gps.gps.enabled = true;
  CekfSlam gps_slam(with_gps, drive.vehicle);
  EXPECT_THAT([&] { gps_slam.loadState(state, kName, MapUse::kExtend); },
              ThrowsMessage<InputError>(HasSubstr("GPS was fused")));
  VehicleConfig calibrated = drive.vehicle;
  double& deviation = calibrated.calibration.speed_scale_deviation;
  deviation = deviation > 0.0 ? 0.0 : 0.1;
  CekfSlam other(drive.config, calibrated);
  EXPECT_THAT([&] { other.loadState(state, kName, MapUse::kExtend); },
              ThrowsMessage<InputError>(HasSubstr("calibration")));
  EXPECT_EQ(other.counts().resets, 0U);
}

TEST(SavedFilter, IsRefusedWhereverItIsCutOffAndNothingIsTouched) {
  const Drive drive = core::drive(false, 15.0);
  CekfSlam slam(drive.config, drive.vehicle);
  process(slam, drive, 0, drive.events.size());
  const std::string state = slam.saveState();
  for (std::size_t size = 0; size < state.size(); size += 1 + state.size() / 200) {
    EXPECT_THROW(slam.loadState(state.substr(0, size), kName, MapUse::kExtend), InputError);
  }
  EXPECT_THROW(slam.loadState(state + "x", kName, MapUse::kExtend), InputError);
  EXPECT_TRUE(slam.saveState() == state);
}

/// Content that no program has written, with a checksum that fits: refused, or at least survived.
TEST(SavedFilter, SurvivesAnyByteThatIsNotAsItWas) {
  const Drive drive = core::drive(false, 15.0);
  CekfSlam mapper(drive.config, drive.vehicle);
  process(mapper, drive, 0, drive.events.size() - 200);
  const std::string state = mapper.saveState();
  std::mt19937 generator(1);
  int refused = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::string damaged = state;
    // Away from the tiles, whose numbers are any: the front and the back hold the structure.
    const std::size_t reach = std::min<std::size_t>(state.size(), 6000);
    const std::size_t at =
        trial % 2 == 0 ? generator() % 200 : state.size() - 1 - generator() % reach;
    damaged[at] = static_cast<char>(generator());
    CekfSlam slam(drive.config, drive.vehicle);
    try {
      slam.loadState(damaged, kName, MapUse::kExtend);
      process(slam, drive, drive.events.size() - 200, drive.events.size());
    } catch (const std::exception&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 5);
}

}  // namespace
}  // namespace hymm::core
