#include "pipeline/door_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/landmark_triangle.h"

namespace hymm::core {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Key;
using testing::Not;

std::map<std::string, std::size_t> incidentsWithCellsOf(double resolution_m) {
  HymmGridConfig grid;
  grid.map.resolution_m = resolution_m;
  grid.map.max_memory_mb = 1e6;
  grid.map.occupancy.range_m = 1.0;
  GridMapper mapper(grid);
  // An LTR of 20 m.
  const auto landmarks = std::make_shared<const LandmarkMap>(
      test::landmarkTriangle({{{-8.0, -8.0}, {12.0, -8.0}, {-8.0, 12.0}}}));
  MappedScan mapped;
  mapped.pose.map_version = 1;
  mapped.update.version = 1;
  mapped.map = landmarks;
  EXPECT_TRUE(mapper.process(mapped).follows);
  EXPECT_EQ(mapper.topology().size(), 1U);

  DoorPlannerConfig config;
  config.goal = "3 -3";
  DoorStage stage(config);
  stage.readMapOf(mapper);
  CekfSlam filter(CekfSlamConfig{}, VehicleConfig{});
  const SensorEvent event = ObservationSet{};
  stage.takeScan({event, ScanOutcome{}, LandmarkUpdate{}, landmarks}, filter);
  return stage.incidents();
}

TEST(DoorStage, TellsOfLtrsThatPathsCannotGoThrough) {
  EXPECT_THAT(incidentsWithCellsOf(0.005), Contains(Key(HasSubstr("has more cells than plans"))));
  EXPECT_THAT(incidentsWithCellsOf(0.2), Not(Contains(Key(HasSubstr("left out")))));
}

}  // namespace
}  // namespace hymm::core
