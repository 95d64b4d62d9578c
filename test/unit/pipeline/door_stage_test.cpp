#include "pipeline/door_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Key;
using testing::Not;

/// Three landmarks that span an LTR of 20 m around the origin.
std::shared_ptr<const LandmarkMap> triangle() {
  auto map = std::make_shared<LandmarkMap>();
  map->version = 1;
  const double places[3][2] = {{-8.0, -8.0}, {12.0, -8.0}, {-8.0, 12.0}};
  for (int id = 0; id < 3; ++id) {
    LandmarkEstimate landmark;
    landmark.id = id;
    landmark.position = {places[id][0], places[id][1]};
    landmark.covariance = 0.01 * Eigen::Matrix2d::Identity();
    landmark.observations = 20;
    map->landmarks.push_back(landmark);
    for (int other = 0; other < id; ++other) {
      map->cross_covariances.push_back({other, id, 0.0099 * Eigen::Matrix2d::Identity()});
    }
  }
  return map;
}

std::map<std::string, std::size_t> incidentsWithCellsOf(double resolution_m) {
  HymmGridConfig grid;
  grid.map.resolution_m = resolution_m;
  grid.map.max_memory_mb = 1e6;
  grid.map.occupancy.range_m = 1.0;
  GridMapper mapper(grid);
  MappedScan mapped;
  mapped.pose.map_version = 1;
  mapped.update.version = 1;
  mapped.map = triangle();
  EXPECT_TRUE(mapper.process(mapped).follows);
  EXPECT_EQ(mapper.topology().size(), 1U);

  DoorPlannerConfig config;
  config.goal = "3 -3";
  DoorStage stage(config);
  stage.readMapOf(mapper);
  CekfSlam filter(CekfSlamConfig{}, VehicleConfig{});
  const SensorEvent event = ObservationSet{};
  stage.takeScan({event, ScanOutcome{}, LandmarkUpdate{}, triangle()}, filter);
  return stage.incidents();
}

TEST(DoorStage, TellsOfLtrsThatPathsCannotGoThrough) {
  EXPECT_THAT(incidentsWithCellsOf(0.005), Contains(Key(HasSubstr("has more cells than plans"))));
  EXPECT_THAT(incidentsWithCellsOf(0.2), Not(Contains(Key(HasSubstr("left out")))));
}

}  // namespace
}  // namespace hymm::core
