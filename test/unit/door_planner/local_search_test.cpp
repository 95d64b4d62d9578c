#include "door_planner/local_search.h"

#include <cmath>
#include <functional>
#include <queue>
#include <stdexcept>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/random.h"
#include "door_planner/cost_matrix.h"
#include "support/planner_meshes.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

/// A right triangle with legs of 16 m and square cells of 0.2 m, on which a metre of free ground
/// costs 1.
struct Field {
  LtrView ltr = test::SquareMesh(1, 1, 16.0, 0.2).ltrs.front();
  PathCostConfig config;
  Triangle triangle{ltr.corners};

  CellCosts costs(const std::function<float(const Vector2d&)>& occupancy) const {
    return {config, {}, gridOf(ltr.alpha_cells, ltr.beta_cells), test::contentOf(ltr, occupancy)};
  }
  LocalPath find(const CellCosts& costs, const Vector2d& from, const Vector2d& to) const {
    LocalSearch search(triangle, costs, 0.02);
    return search.find(triangle.toLocal(from), {triangle.toLocal(to)}).front();
  }
};

float freeGround(const Vector2d&) { return 0.0F; }

TEST(LocalSearch, GoesStraightOverFreeGround) {
  const Field field;
  const CellCosts costs = field.costs(freeGround);
  const LocalPath path = field.find(costs, {1.0, 2.0}, {9.0, 5.5});
  EXPECT_NEAR(path.cost, Vector2d(8.0, 3.5).norm(), 1e-9);
  EXPECT_EQ(path.points.size(), 2U);
}

TEST(LocalSearch, GoesRoundAWallByItsCorner) {
  const Field field;
  // Cells from x = 4 to 4.2 and up to y = 6: the shortest way touches the corners at y = 6.
  const CellCosts costs =
      field.costs([](const Vector2d& p) { return std::abs(p.x() - 4.1) < 0.1 && p.y() < 6.0; });
  const Vector2d from(1.1, 2.1), to(7.1, 2.1);
  const double shortest = 2.0 * (Vector2d(4.0, 6.0) - from).norm() + 0.2 - 0.1;
  const LocalPath path = field.find(costs, from, to);
  // It turns at centres of cells, half a cell beyond the corners, and is found along steps.
  EXPECT_GT(path.cost, shortest);
  EXPECT_LT(path.cost, shortest * 1.03);
}

TEST(LocalSearch, FindsNoWayThroughAClosedWall) {
  const Field field;
  const CellCosts costs =
      field.costs([](const Vector2d& p) { return std::abs(p.x() - 4.1) < 0.1; });
  EXPECT_FALSE(field.find(costs, {1.0, 2.0}, {9.0, 2.0}).exists());
}

TEST(LocalSearch, AvoidsUnknownGroundAsFarAsItsCostSays) {
  Field field;
  const auto unknown_strip = [](const Vector2d& p) {
    return std::abs(p.x() - 4.0) < 1.0 && p.y() < 6.0 ? NAN : 0.0F;
  };
  field.config.unknown = 0.1;
  const double straight = field.find(field.costs(unknown_strip), {1.0, 1.1}, {8.0, 1.1}).cost;
  EXPECT_NEAR(straight, 7.0 + 0.1 * 2.0, 1e-6);
  field.config.unknown = 100.0;
  const double around = field.find(field.costs(unknown_strip), {1.0, 1.1}, {8.0, 1.1}).cost;
  const double shortest = Vector2d(2.0, 4.9).norm() + 2.0 + Vector2d(4.0 - 1.0, 4.9).norm();
  EXPECT_GT(around, shortest);
  EXPECT_LT(around, shortest * 1.03);
}

TEST(LocalSearch, CrossesGroundThatIsAThousandMillionTimesDearerWhereItIsThinnest) {
  Field field;
  field.config.unknown = PathCostConfig::kDearest;
  // From side to side, 2 m thick but for 0.4 m around y = 6.
  const CellCosts costs = field.costs([](const Vector2d& p) {
    return std::abs(p.x() - 4.0) < (std::abs(p.y() - 6.0) < 0.6 ? 0.2 : 1.0) ? NAN : 0.0F;
  });
  const LocalPath path = field.find(costs, {1.1, 1.1}, {8.1, 1.1});
  EXPECT_NEAR(path.cost, 0.4 * field.config.unknown, 0.01 * field.config.unknown);
}

/// Cheapest cost of a way along steps between cells' centres, looked for without any bound or
/// bucket.
double cheapestAlongSteps(const Field& field, const CellCosts& costs, const Vector2d& from,
                          const Vector2d& to) {
  const TriangularGrid& grid = costs.grid();
  const CellMetric metric(field.triangle, grid.alphaCells(), grid.betaCells(), 0.02);
  std::vector<double> cost(std::size_t(grid.cellCount()), kNoPassing);
  const auto cellAt = [&](const Vector2d& place) {
    const Vector2d cells = grid.toCells(field.triangle.toLocal(place));
    return Eigen::Vector2i(static_cast<int>(cells.x()), static_cast<int>(cells.y()));
  };
  using Waiting = std::tuple<double, int, int>;
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting;
  const auto offer = [&](const Eigen::Vector2i& cell, double offered) {
    double& known = cost[std::size_t(grid.index(cell.x(), cell.y()))];
    if (offered >= known) return;
    known = offered;
    waiting.emplace(offered, cell.x(), cell.y());
  };
  offer(cellAt(from), 0.0);
  while (!waiting.empty()) {
    const auto [reached, i, j] = waiting.top();
    waiting.pop();
    if (reached > cost[std::size_t(grid.index(i, j))]) continue;
    for (const CellStep& step : metric.steps()) {
      const Eigen::Vector2i next(i + step.di, j + step.dj);
      // Centres inside the triangle, whose legs have as many cells.
      if (next.minCoeff() < 0 || next.sum() + 1 > grid.alphaCells()) continue;
      double sum = 0.0;
      for (const CellStep::Pass& pass : step.passes) {
        const auto passed =
            static_cast<double>(costs.perMetre(grid.index(i + pass.di, j + pass.dj)));
        sum += pass.share * step.length_m * (passed > 0.0 ? passed : kNoPassing);
      }
      offer(next, reached + sum);
    }
  }
  const Eigen::Vector2i end = cellAt(to);
  return cost[std::size_t(grid.index(end.x(), end.y()))];
}

TEST(LocalSearch, IsNoDearerThanAnyWayAlongStepsHoweverDearGroundIs) {
  RandomGenerator generator(4);
  for (const double dearest : {10.0, 1e4, 1e8}) {
    Field field;
    field.ltr = test::SquareMesh(1, 1, 16.0, 0.5).ltrs.front();
    // Of every size between 1 and the dearest, in patches of a metre.
    field.config.occupancy = dearest;
    field.config.occupied_probability = 0.99;
    field.config.probability_step = 0.0;
    std::vector<float> patches(17 * 17);
    for (float& patch : patches) {
      patch = static_cast<float>(0.9 * std::pow(dearest, -sampleUniform(generator, 0.0, 1.0)));
    }
    const CellCosts costs = field.costs(
        [&](const Vector2d& p) { return patches[std::size_t(p.x()) * 17 + std::size_t(p.y())]; });
    for (const Vector2d& to :
         {Vector2d(14.25, 0.75), Vector2d(0.75, 14.25), Vector2d(7.75, 7.25)}) {
      const Vector2d from(0.25, 0.25);
      const double cost = field.find(costs, from, to).cost;
      EXPECT_LE(cost, cheapestAlongSteps(field, costs, from, to) * (1.0 + 1e-5))
          << "dearest " << dearest;
    }
  }
}

TEST(LocalSearch, PaysForClimbingOnly) {
  Field field;
  LtrContent content = test::contentOf(field.ltr, freeGround);
  // One metre in ten along x.
  content.properties["height"] = test::contentOf(field.ltr, [](const Vector2d& p) {
                                   return static_cast<float>(0.1 * p.x());
                                 }).occupancy;
  std::vector<std::string> problems;
  field.config.properties = "height climb 5";
  const CellCosts costs(field.config, field.config.weights(problems),
                        gridOf(field.ltr.alpha_cells, field.ltr.beta_cells), content);
  EXPECT_NEAR(field.find(costs, {1.1, 1.1}, {9.1, 1.1}).cost, 8.0 + 5.0 * 0.8, 1e-4);
  EXPECT_NEAR(field.find(costs, {9.1, 1.1}, {1.1, 1.1}).cost, 8.0, 1e-4);
}

TEST(LocalSearch, SearchesToAPlaceAsFromIt) {
  const Field field;
  const CellCosts costs =
      field.costs([](const Vector2d& p) { return std::abs(p.x() - 4.1) < 0.1 && p.y() < 6.0; });
  LocalSearch search(field.triangle, costs, 0.02);
  const Triangle::Local a = field.triangle.toLocal({1.1, 2.1}),
                        b = field.triangle.toLocal({7.1, 2.1});
  const LocalPath there = search.find(a, {b}, LocalSearch::Direction::kFrom).front();
  const LocalPath back = search.find(b, {a}, LocalSearch::Direction::kTo).front();
  EXPECT_NEAR(there.cost, back.cost, 0.01 * there.cost);
  EXPECT_TRUE(back.points.front().isApprox(a));
  EXPECT_TRUE(back.points.back().isApprox(b));
}

TEST(LocalSearch, ReturnsPathsThatCrossNothingOccupiedAndCostWhatTheySay) {
  const Field field;
  RandomGenerator generator(3);
  for (int trial = 0; trial < 30; ++trial) {
    const CellCosts costs = field.costs([&](const Vector2d&) {
      const double draw = sampleUniform(generator, 0.0, 1.0);
      return draw < 0.15 ? 1.0F : static_cast<float>(0.5 * draw);
    });
    LocalSearch search(field.triangle, costs, 0.02);
    const Triangle::Local from(0.05, 0.06), to(0.6, 0.3);
    const LocalPath path = search.find(from, {to}).front();
    if (!path.exists()) continue;
    double sum = 0.0;
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      sum += search.integrate(path.points[i - 1], path.points[i]);
    }
    EXPECT_NEAR(sum, path.cost, 1e-9);
  }
}

TEST(CellCosts, RefusesContentOfAnotherGrid) {
  const Field field;
  LtrContent content;
  content.occupancy.assign(3, 0.0F);
  EXPECT_THROW(CellCosts(field.config, {}, gridOf(10, 10), content), std::invalid_argument);
}

TEST(CellCosts, PassesNothingThatIsOccupiedHoweverDearALayerMakesIt) {
  Field field;
  field.config.properties = "mud 1";
  std::vector<std::string> problems;
  LtrContent content = test::contentOf(field.ltr, freeGround);
  content.properties["mud"].assign(content.occupancy.size(),
                                   std::numeric_limits<float>::infinity());
  content.occupancy[7] = 1.0F;
  const CellCosts costs(field.config, field.config.weights(problems),
                        gridOf(field.ltr.alpha_cells, field.ltr.beta_cells), content);
  EXPECT_TRUE(costs.isOccupied(7));
  EXPECT_EQ(costs.perMetre(8), static_cast<float>(PathCostConfig::kDearest));
}

TEST(PathCostConfig, RefusesNegativeWeightsByName) {
  PathCostConfig config;
  config.properties = "traffic -1; terrain.grass 0.5; height climb x";
  std::vector<std::string> problems;
  EXPECT_EQ(config.weights(problems).size(), 1U);
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_THAT(problems[0], testing::HasSubstr("traffic -1"));
  EXPECT_THAT(problems[1], testing::HasSubstr("height climb x"));
}

TEST(DoorPlannerConfig, RefusesWeightsThatMakeAllGroundFree) {
  DoorPlannerConfig config;
  config.cost.distance = 0.0;
  ASSERT_EQ(config.problems().size(), 1U);
  EXPECT_THAT(config.problems().front(), testing::HasSubstr("cost.distance"));
  config.cost.distance = 1e-40;
  ASSERT_EQ(config.problems().size(), 1U) << "no number that costs are kept in";
}

TEST(DoorPlannerConfig, RefusesWeightsThatSumsCannotHold) {
  DoorPlannerConfig config;
  config.cost.unknown = 1e30;
  config.cost.properties = "mud 1e30; height climb 1e30; traffic forbidden 1e30";
  EXPECT_THAT(config.problems(),
              testing::UnorderedElementsAre(testing::HasSubstr("cost.unknown"),
                                            testing::HasSubstr("'mud 1e30'"),
                                            testing::HasSubstr("' height climb 1e30'")));
}

TEST(CostMatrix, ObeysTheTriangleInequality) {
  const Field field;
  RandomGenerator generator(5);
  const CellCosts costs =
      field.costs([&](const Vector2d&) { return sampleUniform(generator, 0.0, 1.0) < 0.1; });
  std::vector<Triangle::Local> portals;
  for (int i = 1; i < 5; ++i) {
    portals.emplace_back(0.2 * i, 0.0);
    portals.emplace_back(1.0 - 0.2 * i, 0.2 * i);
    portals.emplace_back(0.0, 1.0 - 0.2 * i);
  }
  LocalSearch search(field.triangle, costs, 0.02);
  const CostMatrix matrix(search, portals, false);
  for (int j = 0; j < matrix.size(); ++j) {
    for (int k = 0; k < matrix.size(); ++k) {
      EXPECT_EQ(matrix.cost(j, k), matrix.cost(k, j));
      for (int l = 0; l < matrix.size(); ++l) {
        EXPECT_LE(matrix.cost(j, l), (matrix.cost(j, k) + matrix.cost(k, l)) * (1.0F + 1e-5F));
      }
    }
  }
}

TEST(CostMatrix, KeepsThePathsThatItsCostsAreOf) {
  const Field field;
  RandomGenerator generator(6);
  const CellCosts costs =
      field.costs([&](const Vector2d&) { return sampleUniform(generator, 0.0, 1.0) < 0.1; });
  const std::vector<Triangle::Local> portals = {{0.3, 0.0}, {0.7, 0.0}, {0.5, 0.5}, {0.0, 0.4}};
  LocalSearch search(field.triangle, costs, 0.02);
  const CostMatrix matrix(search, portals, false);
  for (int j = 0; j < matrix.size(); ++j) {
    for (int k = 0; k < matrix.size(); ++k) {
      if (matrix.cost(j, k) == std::numeric_limits<float>::infinity()) continue;
      std::vector<Triangle::Local> points = matrix.turns(j, k);
      points.insert(points.begin(), portals[std::size_t(j)]);
      points.push_back(portals[std::size_t(k)]);
      double sum = 0.0;
      for (std::size_t i = 1; i < points.size(); ++i) {
        sum += search.integrate(points[i - 1], points[i]);
      }
      EXPECT_NEAR(sum, static_cast<double>(matrix.cost(j, k)), 1e-4);
    }
  }
}

}  // namespace
}  // namespace hymm::core
