#include "information_map/level_set_search.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "dense_images.h"
#include "information_map/full_evaluation.h"
#include "information_map/sight_map.h"
#include "random_landmarks.h"
#include "support/map_history.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;
using testing::IsEmpty;

std::shared_ptr<const LandmarkField> fieldOf(const LandmarkMap& map) {
  return std::make_shared<const LandmarkField>(map, 15.0);
}

/// Rings of six landmarks of 8 m around each centre: inside, information is high.
LandmarkMap rings(const std::vector<Vector2d>& centres, double deviation_m = 0.03) {
  std::vector<Vector2d> places;
  for (const Vector2d& centre : centres) {
    for (int i = 0; i < 6; ++i) {
      places.emplace_back(centre + 8.0 * Vector2d(std::cos(i * kPi / 3), std::sin(i * kPi / 3)));
    }
  }
  const auto n = Eigen::Index(2 * places.size());
  return mapOf(places, deviation_m * deviation_m * Eigen::MatrixXd::Identity(n, n));
}

void expectEqualsFull(const LevelSetSearch& search, const InformationMapConfig& config,
                      const LandmarkField& field, double least) {
  const FullEvaluation full = evaluateFully(config, field);
  for (int level = 1; level <= search.lattice().levels(); ++level) {
    EXPECT_GE(intersectionOverUnion(search.lattice(), full.lattice, level), least)
        << "level " << level;
  }
}

TEST(LevelSetSearch, EqualsFullEvaluationWhileAMapGrows) {
  const InformationMapConfig config;
  LevelSetSearch search(config);
  auto history = test::simulatedHistory("park", 1, 7);
  int changes = 0;
  while (const auto version = history.next()) {
    const auto field = fieldOf(version->map);
    search.update(field, version->pose.T_map_base.position());
    if (++changes % 20 == 0) expectEqualsFull(search, config, *field, 0.99);
  }
  EXPECT_GT(changes, 60);
}

TEST(LevelSetSearch, EqualsFullEvaluationWithEachHeading) {
  for (const char* heading : {"worst", "best", "fixed"}) {
    SCOPED_TRACE(heading);
    InformationMapConfig config;
    config.information.heading = heading;
    config.information.sensor.field_of_view_rad = 5.0;
    config.level_sets.values = "10 40";
    LevelSetSearch search(config);
    auto history = test::simulatedHistory("park", 1, 8);
    std::shared_ptr<const LandmarkField> field;
    for (int i = 0; i < 30; ++i) {
      const auto version = history.next();
      ASSERT_TRUE(version);
      field = fieldOf(version->map);
      search.update(field, version->pose.T_map_base.position());
    }
    EXPECT_GT(search.lattice().cellsReaching(1), 50U);
    expectEqualsFull(search, config, *field, 0.99);
  }
}

TEST(LevelSetSearch, EqualsFullEvaluationWhileWallsAreFoundAndLost) {
  InformationMapConfig config;
  config.dense_map.landmark_clearance_m = 0.0;
  std::shared_ptr<const SightMap> sight;
  const auto hides = [&sight](const Vector2d& from, const Vector2d& to) {
    return sight && sight->hides(from, to);
  };
  LevelSetSearch search(config, hides);
  const auto changeTo = [&](const OccupancyImage& image) {
    auto next = std::make_shared<const SightMap>(config.dense_map, image);
    const double half_m = std::sqrt(0.5) * image.resolution_m;
    search.noteChangedLooks(next->occupiedUnlike(sight.get()), half_m, 0.0);
    if (sight) search.noteChangedLooks(sight->occupiedUnlike(next.get()), half_m, 0.0);
    sight = std::move(next);
  };
  auto history = test::simulatedHistory("park", 1, 11);
  RandomGenerator generator(11);
  for (int i = 0; i < 60; ++i) {
    const auto version = history.next();
    ASSERT_TRUE(version);
    const auto field = fieldOf(version->map);
    if (i % 10 == 5) {  // other walls and posts in all of the map than before
      OccupancyImage image = freeImage(-100.0, -100.0, 100.0, 100.0);
      for (int wall = 0; wall < 300; ++wall) {
        const Vector2d low =
            field->low() + (field->high() - field->low())
                               .cwiseProduct(Vector2d(sampleUniform(generator, 0.0, 1.0),
                                                      sampleUniform(generator, 0.0, 1.0)));
        const double length_m = wall % 3 == 0 ? 0.3 : 6.0;
        fillBox(image, low.x(), low.y(), low.x() + (wall % 2 == 0 ? length_m : 0.1),
                low.y() + (wall % 2 == 0 ? 0.1 : length_m));
      }
      changeTo(image);
    }
    search.update(field, version->pose.T_map_base.position());
    if (i % 10 != 5) continue;
    const FullEvaluation full = evaluateFully(config, *field, hides);
    const FullEvaluation unhidden = evaluateFully(config, *field);
    for (int level = 1; level <= search.lattice().levels(); ++level) {
      // What walls hide is much more than what the search may miss.
      EXPECT_LT(intersectionOverUnion(unhidden.lattice, full.lattice, level), 0.9);
      EXPECT_GE(intersectionOverUnion(search.lattice(), full.lattice, level), 0.99)
          << "level " << level << " at change " << i;
    }
  }
}

TEST(LevelSetSearch, EvaluatesFarLessThanAFullGridOrAQuadtreeFromScratch) {
  const InformationMapConfig config;
  LevelSetSearch search(config);
  auto history = test::simulatedHistory("park", 2, 9);
  std::size_t incremental = 0, full = 0, scratch = 0;
  for (int i = 1; i <= 200; ++i) {
    const auto version = history.next();
    ASSERT_TRUE(version);
    const auto field = fieldOf(version->map);
    incremental += search.update(field, version->pose.T_map_base.position()).evaluations;
    if (i % 20 != 0) continue;
    full += 20 * evaluateFully(config, *field).evaluations;
    scratch += 20 * LevelSetSearch(config).update(field, Vector2d::Zero()).evaluations;
  }
  EXPECT_GT(full, 40 * incremental);
  EXPECT_GT(scratch, 5 * incremental);
}

TEST(LevelSetSearch, RepeatsItself) {
  LevelSetSearch a{InformationMapConfig{}}, b{InformationMapConfig{}};
  auto history = test::simulatedHistory("park", 1, 10);
  for (int i = 0; i < 40; ++i) {
    const auto version = history.next();
    ASSERT_TRUE(version);
    const auto one = a.update(fieldOf(version->map), version->pose.T_map_base.position());
    const auto other = b.update(fieldOf(version->map), version->pose.T_map_base.position());
    ASSERT_EQ(one.evaluations, other.evaluations);
  }
  EXPECT_EQ(intersectionOverUnion(a.lattice(), b.lattice(), 1), 1.0);
}

TEST(LevelSetSearch, NestsItsSets) {
  InformationMapConfig config;
  config.level_sets.values = "20 50 80";
  LevelSetSearch search(config);
  RandomGenerator generator(1);
  const auto places = randomPlaces(30, 40.0, generator);
  search.update(fieldOf(mapOf(places, 0.04 * Eigen::MatrixXd::Identity(60, 60))), Vector2d::Zero());
  const LevelLattice& lattice = search.lattice();
  EXPECT_GT(lattice.cellsReaching(1), lattice.cellsReaching(2));
  EXPECT_GT(lattice.cellsReaching(2), lattice.cellsReaching(3));
  EXPECT_GT(lattice.cellsReaching(3), 0U);
}

TEST(LevelSetSearch, FindsAnIslandByExplorationPoints) {
  const InformationMapConfig config;
  LevelSetSearch search(config);
  search.update(fieldOf(rings({{0.0, 0.0}})), Vector2d::Zero());
  ASSERT_EQ(search.islands(1).islands().size(), 1U);
  const auto field = fieldOf(rings({{0.0, 0.0}, {90.0, 10.0}}));
  search.update(field, Vector2d::Zero());
  EXPECT_EQ(search.islands(1).islands().size(), 2U);
  expectEqualsFull(search, config, *field, 0.99);
}

TEST(LevelSetSearch, JoinsIslandsThatGrowTogether) {
  LevelSetSearch search{InformationMapConfig{}};
  search.update(fieldOf(rings({{0.0, 0.0}, {60.0, 0.0}, {60.0, 12.0}})), Vector2d::Zero());
  const LevelIslands& islands = search.islands(1);
  ASSERT_EQ(islands.islands().size(), 2U);
  const int small = islands.islandOf(search.lattice(), {0, 0});
  const int large = islands.islandOf(search.lattice(), {60, 0});
  search.update(fieldOf(rings({{0.0, 0.0}, {60.0, 0.0}, {60.0, 12.0}, {20.0, 0.0}, {40.0, 0.0}})),
                Vector2d::Zero());
  ASSERT_EQ(islands.islands().size(), 1U);
  EXPECT_EQ(islands.islands()[0].id, large);
  ASSERT_EQ(islands.joined().size(), 1U);
  EXPECT_EQ(islands.joined()[0].id, small);
  EXPECT_EQ(islands.joined()[0].into_id, large);
}

TEST(LevelSetSearch, LosesWhatItsLandmarksHeld) {
  const InformationMapConfig config;
  LevelSetSearch search(config);
  search.update(fieldOf(rings({{0.0, 0.0}, {40.0, 0.0}})), Vector2d::Zero());
  const double before = search.lattice().area_m2(1);
  const auto field = fieldOf(rings({{0.0, 0.0}}));
  const LevelSetUpdate update = search.update(field, Vector2d::Zero());
  EXPECT_NEAR(update.levels[0].lost_m2, before - search.lattice().area_m2(1), 1e-9);
  EXPECT_GT(update.levels[0].lost_m2, 100.0);
  EXPECT_EQ(update.levels[0].lost_moving_m2, update.levels[0].lost_m2);
  expectEqualsFull(search, config, *field, 0.99);
}

TEST(LevelSetSearch, KeepsLossesUntilTheLandmarksMove) {
  InformationMapConfig config;
  config.level_sets.losses = "keep";
  LevelSetSearch search(config);
  search.update(fieldOf(rings({{0.0, 0.0}})), Vector2d::Zero());
  const double before = search.lattice().area_m2(1);
  const auto worse = search.update(fieldOf(rings({{0.0, 0.0}}, 0.25)), Vector2d::Zero());
  EXPECT_EQ(search.lattice().area_m2(1), before);
  EXPECT_GT(worse.levels[0].kept_m2, 0.0);
  const auto field = fieldOf(rings({{3.0, 0.0}}, 0.25));
  search.update(field, Vector2d::Zero());
  search.update(fieldOf(rings({{3.1, 0.0}}, 0.25)), Vector2d::Zero());
  EXPECT_LT(search.lattice().area_m2(1), before);
}

TEST(LevelSetSearch, FollowsACorrectionOfTheWholeMap) {
  const InformationMapConfig config;
  LevelSetSearch search(config);
  search.update(fieldOf(rings({{0.0, 0.0}, {12.0, 3.0}, {60.0, 0.0}})), Vector2d::Zero());
  const auto moved = fieldOf(rings({{4.0, -3.0}, {16.0, 0.0}, {64.0, -3.0}}));
  const LevelSetUpdate update = search.update(moved, Vector2d::Zero());
  expectEqualsFull(search, config, *moved, 0.99);
  EXPECT_GT(update.levels[0].lost_m2, 50.0);
  // What was in the set moved along with the landmarks and still is; at the border a cell's centre
  // may be out.
  EXPECT_LT(update.levels[0].lost_moving_m2, 0.1 * update.levels[0].lost_m2);
}

TEST(LevelSetSearch, GoesOnWhereItsEvaluationsEnded) {
  InformationMapConfig config;
  config.level_sets.max_evaluations = 150;
  LevelSetSearch search(config);
  const auto field = fieldOf(rings({{0.0, 0.0}, {50.0, 0.0}, {100.0, 40.0}}));
  LevelSetUpdate update = search.update(field, Vector2d::Zero());
  EXPECT_FALSE(update.is_complete);
  EXPECT_LE(update.evaluations, 150U + 85U);  // a block of 8 x 8 that is begun is ended
  int updates = 1;
  for (; !update.is_complete && updates < 100; ++updates) {
    update = search.update(field, Vector2d::Zero());
  }
  EXPECT_TRUE(update.is_complete);
  expectEqualsFull(search, config, *field, 0.99);
}

TEST(LevelSetSearch, ServesTheVehiclesIslandFirst) {
  InformationMapConfig config;
  config.level_sets.max_evaluations = 400;
  LevelSetSearch search(config);
  const auto update = search.update(fieldOf(rings({{0.0, 0.0}, {200.0, 0.0}})), {200.0, 0.0});
  EXPECT_FALSE(update.is_complete);
  EXPECT_GT(search.lattice().levelAt({200.0, 0.0}), 0);
  EXPECT_EQ(search.lattice().levelAt({0.0, 0.0}), 0);
}

TEST(LevelSetSearch, IsEmptyWithoutLandmarks) {
  LevelSetSearch search{InformationMapConfig{}};
  const LevelSetUpdate update = search.update(fieldOf(LandmarkMap{}), Vector2d::Zero());
  EXPECT_THAT(update.refused, IsEmpty());
  EXPECT_EQ(update.evaluations, 0U);
  EXPECT_TRUE(update.is_complete);
  EXPECT_THAT(search.islands(1).islands(), IsEmpty());
  search.update(fieldOf(rings({{0.0, 0.0}})), Vector2d::Zero());
  EXPECT_GT(search.lattice().cellsReaching(1), 0U);
}

TEST(LevelSetSearch, IsEmptyWithOneLandmark) {
  LevelSetSearch search{InformationMapConfig{}};
  const auto map = mapOf({{3.0, 4.0}}, 1e-4 * Eigen::MatrixXd::Identity(2, 2));
  EXPECT_TRUE(search.update(fieldOf(map), Vector2d::Zero()).is_complete);
  EXPECT_EQ(search.lattice().cellsReaching(1), 0U);
}

TEST(LevelSetSearch, RefusesAResolutionTooFineForTheArea) {
  InformationMapConfig config;
  config.level_sets.resolution_m = 0.005;
  LevelSetSearch search(config);
  const LevelSetUpdate update = search.update(fieldOf(rings({{0.0, 0.0}})), Vector2d::Zero());
  EXPECT_THAT(update.refused, HasSubstr("0.005 m would be up to 9.57128e+07"));
  EXPECT_THAT(update.refused, HasSubstr("choose at least 0.0109381 m"));
  EXPECT_EQ(update.evaluations, 0U);
}

TEST(LevelSetSearch, RefusesALandmarkBeyondItsLattice) {
  LevelSetSearch search{InformationMapConfig{}};
  const LevelSetUpdate update = search.update(fieldOf(rings({{1e12, 0.0}})), Vector2d::Zero());
  EXPECT_THAT(update.refused, HasSubstr("diverging"));
}

TEST(LevelSetSearch, RefusesAConfigurationThatCannotWork) {
  InformationMapConfig config;
  config.level_sets.values = "-1";
  EXPECT_THROW(LevelSetSearch{config}, ConfigError);
}

}  // namespace
}  // namespace hymm::core
