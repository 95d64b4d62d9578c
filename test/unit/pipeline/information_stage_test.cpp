#include "pipeline/information_stage.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::shared_ptr<const LandmarkMap> triangle() {
  auto map = std::make_shared<LandmarkMap>();
  map->version = 3;
  const double places[3][2] = {{5.0, 0.0}, {-3.0, 6.0}, {-3.0, -6.0}};
  for (int id = 0; id < 3; ++id) {
    LandmarkEstimate landmark;
    landmark.id = id;
    landmark.position = {places[id][0], places[id][1]};
    landmark.covariance = 1e-3 * Eigen::Matrix2d::Identity();
    map->landmarks.push_back(landmark);
    for (int other = 0; other < id; ++other) {
      map->cross_covariances.push_back({other, id, Eigen::Matrix2d::Zero()});
    }
  }
  return map;
}

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(InformationStage, WritesLeavesAndChangesOfItsSets) {
  InformationStage stage({}, VehicleConfig{});
  CekfSlam filter(CekfSlamConfig{}, VehicleConfig{});
  const SensorEvent event = ObservationSet{};
  const ScanOutcome outcome;
  const LandmarkUpdate update;
  stage.takeScan({event, outcome, update, triangle()}, filter);
  stage.takeScan({event, outcome, update, nullptr}, filter);  // no map was due

  const test::TemporaryFolder folder;
  stage.write(folder.path());
  const std::string leaves = contentOf(folder.path() / "level_sets.csv");
  EXPECT_THAT(leaves, StartsWith("value,x,y,edge,island\n25,"));
  EXPECT_THAT(leaves, HasSubstr("\n100,"));
  const std::string changes = contentOf(folder.path() / "information_changes.csv");
  EXPECT_EQ(std::count(changes.begin(), changes.end(), '\n'), 3);
  EXPECT_THAT(changes, HasSubstr("\n0,3,25,"));
  EXPECT_THAT(stage.incidents(), IsEmpty());
  RunTotals totals;
  stage.addTo(totals);
  EXPECT_GT(totals.subsystem_cpu_s["information_map"], 0.0);
}

TEST(InformationStage, SuggestsGoalsFromTheLastPose) {
  InformationStage stage({}, VehicleConfig{});
  CekfSlam filter(CekfSlamConfig{}, VehicleConfig{});
  const SensorEvent event = ObservationSet{};
  const test::TemporaryFolder folder;
  stage.write(folder.path());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "exploration.csv"));  // no pose yet
  ScanOutcome outcome;
  outcome.pose.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
  stage.takeScan({event, outcome, LandmarkUpdate{}, triangle()}, filter);
  stage.write(folder.path());
  const std::string goals = contentOf(folder.path() / "exploration.csv");
  EXPECT_THAT(goals, StartsWith("x,y,yaw,way_m,position_deviation_m,"));
  EXPECT_GT(std::count(goals.begin(), goals.end(), '\n'), 2);
}

TEST(InformationStage, ForgetsItsSetsWithTheMap) {
  InformationStage stage({}, VehicleConfig{});
  CekfSlam filter(CekfSlamConfig{}, VehicleConfig{});
  const SensorEvent event = ObservationSet{};
  const ScanOutcome outcome;
  const LandmarkUpdate update;
  stage.takeScan({event, outcome, update, triangle()}, filter);
  stage.reset(1.0);
  EXPECT_EQ(levelSetsText(stage.information().levelSets()), "value,x,y,edge,island\n");
}

}  // namespace
}  // namespace hymm::core
