#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "pipeline/grid_mapper.h"
#include "simulation/simulation.h"

/// What the dense map saves, and how it goes on from there.
namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kName = "The saved map";

HymmGridConfig gridConfig() {
  HymmGridConfig config;
  config.map.layers = "salinity gaussian; terrain category grass asphalt; traffic rate";
  config.map.traffic.layer = "traffic";
  config.map.active_radius_m = 20.0;  // so that cells are compressed
  return config;
}

/// What the filter told of a drive, scan by scan.
const std::vector<MappedScan>& drive() {
  static const std::vector<MappedScan> steps = [] {
    const VehicleConfig vehicle = simulatedCar();
    SimulationConfig config;
    config.world.name = "park";
    config.drive.laps = 1;
    config.drive.duration_s = 60.0;
    config.gps.enabled = false;
    Simulation simulation(config, vehicle, 4);
    const CekfSlamConfig filter_config;
    CekfSlam filter(filter_config, vehicle);
    double next_map_s = 0.0;
    std::vector<MappedScan> made;
    while (auto simulated = simulation.next()) {
      const auto outcome = filter.process(simulated->event);
      if (!outcome || !outcome->accepted) continue;
      MappedScan step;
      step.pose = outcome->pose;
      step.update = filter.takeUpdate();
      step.scan = std::get<ScanEvent>(simulated->event).scan;
      if (step.pose.time_s >= next_map_s) {
        next_map_s = step.pose.time_s + 1.0;
        step.map = std::make_shared<const LandmarkMap>(filter.landmarkMap(30.0));
      }
      made.push_back(std::move(step));
    }
    return made;
  }();
  return steps;
}

void process(GridMapper& mapper, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) mapper.process(drive()[i]);
}

PropertySample sampleAt(const Eigen::Vector2d& place) {
  PropertySample sample;
  sample.layer = "salinity";
  sample.position = place;
  sample.covariance = 1e-4 * Eigen::Matrix2d::Identity();
  sample.sample.value = 0.3;
  sample.sample.variance = 0.01;
  return sample;
}

TEST(SavedDenseMap, GoesOnToTheBitAsIfItHadNeverStopped) {
  for (const double share : {0.1, 0.5}) {
    const auto half = static_cast<std::size_t>(share * static_cast<double>(drive().size()));
    GridMapper whole(gridConfig()), before(gridConfig()), after(gridConfig());
    process(whole, 0, half);
    process(before, 0, half);
    const std::string state = before.saveState();
    after.loadState(state, kName, before.map().landmarkVersion(), MapUse::kExtend);
    EXPECT_TRUE(after.saveState() == state);
    for (GridMapper* mapper : {&whole, &after}) {
      ASSERT_TRUE(mapper->insert(sampleAt(drive()[half].pose.T_map_base.position())).accepted);
      process(*mapper, half, drive().size());
    }
    ASSERT_GT(whole.map().partition().mesh().aliveCount(), 20U);
    for (int layer = 0; layer < whole.map().layers().count(); ++layer) {
      EXPECT_EQ(after.map().evidenceInLtrs(layer), whole.map().evidenceInLtrs(layer));
      EXPECT_EQ(after.map().evidenceWaiting(layer), whole.map().evidenceWaiting(layer));
    }
    EXPECT_TRUE(after.saveState() == whole.saveState()) << "split at " << share;
  }
}

TEST(SavedDenseMap, StaysAsItIsWhileOnlyLocalising) {
  const std::size_t half = drive().size() / 2;
  GridMapper mapper(gridConfig()), fixed(gridConfig());
  process(mapper, 0, half);
  fixed.loadState(mapper.saveState(), kName, mapper.map().landmarkVersion(), MapUse::kLocalise);
  const double evidence = fixed.map().evidenceInLtrs(LayerSet::kOccupancy);
  const std::size_t ltrs = fixed.map().partition().mesh().aliveCount();
  ASSERT_NE(evidence, 0.0);
  for (std::size_t i = half; i < drive().size(); ++i) {
    const MappedOutcome outcome = fixed.process(drive()[i]);
    EXPECT_TRUE(outcome.follows);
    EXPECT_FALSE(outcome.written);
  }
  EXPECT_FALSE(fixed.insert(sampleAt({0.0, 0.0})).accepted);
  EXPECT_EQ(fixed.map().landmarkVersion(), drive().back().update.version);
  EXPECT_EQ(fixed.map().evidenceInLtrs(LayerSet::kOccupancy), evidence);
  EXPECT_EQ(fixed.map().partition().mesh().aliveCount(), ltrs);
}

TEST(SavedDenseMap, OfOtherLayersOrCellsIsRefusedWithTheirNames) {
  GridMapper mapper(gridConfig());
  process(mapper, 0, 20);
  const std::string state = mapper.saveState();
  HymmGridConfig other = gridConfig();
  other.map.layers = "";
  other.map.traffic.layer = "";
  GridMapper without(other);
  EXPECT_THAT([&] { without.loadState(state, kName, 1, MapUse::kExtend); },
              ThrowsMessage<InputError>(HasSubstr("salinity gaussian")));
  other = gridConfig();
  other.map.resolution_m = 0.5;
  GridMapper coarse(other);
  EXPECT_THAT([&] { coarse.loadState(state, kName, 1, MapUse::kExtend); },
              ThrowsMessage<InputError>(HasSubstr("resolution_m is 0.2")));
}

TEST(SavedDenseMap, IsRefusedWhereverItIsCutOffAndNothingIsTouched) {
  GridMapper mapper(gridConfig());
  process(mapper, 0, 60);
  const std::string state = mapper.saveState();
  for (std::size_t size = 0; size < state.size(); size += 1 + state.size() / 300) {
    EXPECT_THROW(mapper.loadState(state.substr(0, size), kName, 1, MapUse::kExtend), InputError);
  }
  EXPECT_THROW(mapper.loadState(state + "x", kName, 1, MapUse::kExtend), InputError);
  EXPECT_TRUE(mapper.saveState() == state);
}

}  // namespace
}  // namespace hymm::core
