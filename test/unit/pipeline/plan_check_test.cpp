#include "pipeline/plan_check.h"

#include <cmath>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "support/landmark_triangle.h"

namespace hymm::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Three trunks of 1 m that span an LTR, and one inside of it that no cell shows.
LandmarkMap trunks() {
  LandmarkMap map = test::landmarkTriangle({{{-5.0, -5.0}, {15.0, -5.0}, {-5.0, 15.0}}});
  LandmarkEstimate inside = map.landmarks[0];
  inside.id = 3;
  inside.position = {1.0, 1.0};
  inside.observations = 1;
  map.landmarks.push_back(inside);
  for (LandmarkEstimate& landmark : map.landmarks) landmark.diameter_m = 1.0;
  return map;
}

/// Least value of a column of the table, of the plans that were found.
double leastOf(const std::string& table, const std::string& column) {
  std::istringstream lines(table);
  std::string line, word;
  std::getline(lines, line);
  std::istringstream header(line);
  int wanted = 0;
  while (std::getline(header, word, ',') && word != column) ++wanted;
  double least = kNaN;
  while (std::getline(lines, line)) {
    if (line.find(",OK,") == std::string::npos) continue;
    std::istringstream words(line);
    for (int k = 0; k <= wanted; ++k) std::getline(words, word, ',');
    least = std::fmin(least, std::stod(word));
  }
  return least;
}

/// The table for a planner that knows of these landmarks.
std::string tableOf(const std::vector<SolidLandmark>& known, bool outside_is_occupied) {
  const LandmarkMap landmarks = trunks();
  HybridMap map{HybridMapConfig()};
  EXPECT_TRUE(map.apply(landmarks).accepted);
  EXPECT_EQ(map.topology(landmarks).size(), 1U);
  DoorPlannerConfig config;
  config.vehicle.width_m = 1.6;
  config.outside_is_occupied = outside_is_occupied;
  DoorPlanner planner(config);
  std::vector<LtrView> views;
  for (const LtrTopology& ltr : map.topology(landmarks)) {
    LtrView view{ltr.id, ltr.landmark_ids, ltr.neighbours, {}, ltr.alpha_cells, ltr.beta_cells,
                 1.0};
    for (std::size_t k = 0; k < 3; ++k) {
      view.corners[k] = landmarks.landmarks[std::size_t(ltr.landmark_ids[k])].position;
    }
    views.push_back(view);
  }
  planner.setLtrs(views);
  planner.setLandmarks(known);
  for (const LtrView& view : views) planner.setContent(view.id, LtrContent());
  planner.prepare(Eigen::Vector2d::Zero());
  return checkQueries(planner, map, landmarks, 100);
}

TEST(CheckQueries, FindsPathsThroughLandmarksThatThePlannerDoesNotKnow) {
  const std::string table = tableOf({}, false);
  EXPECT_LT(leastOf(table, "clearance_m"), -0.5);
  EXPECT_LT(leastOf(table, "refined_clearance_m"), -0.5);
}

TEST(CheckQueries, FindsNoneWhereThePlannerKnowsThem) {
  std::vector<SolidLandmark> known;
  for (const LandmarkEstimate& landmark : trunks().landmarks) {
    known.push_back({landmark.id, landmark.position, landmark.diameter_m});
  }
  for (const bool outside_is_occupied : {false, true}) {
    const std::string table = tableOf(known, outside_is_occupied);
    EXPECT_GE(leastOf(table, "clearance_m"), 0.0);
    EXPECT_GE(leastOf(table, "refined_clearance_m"), 0.0);
  }
}

}  // namespace
}  // namespace hymm::core
