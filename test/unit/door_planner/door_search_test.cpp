#include "door_planner/door_search.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/random.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::discs;
using test::freeGround;
using test::Occupancy;
using World = test::PlannerWorld;

/// Being at a portal in one of its side's two LTRs.
std::size_t stateOf(const DoorGraph& graph, int portal, int ltr) {
  return 2 * std::size_t(portal) + (graph.side(graph.sideOf(portal)).ltrs[0] == ltr ? 0 : 1);
}

/// Cheapest costs from a portal, in one of its LTRs, by Bellman and Ford over every pair of portals
/// of every LTR and every crossing.
std::vector<double> cheapestAlongPortals(const DoorGraph& graph, int from, int in,
                                         const Admits& admits = {}) {
  std::vector<double> cost(2 * std::size_t(graph.portalCount()), kNoPassing);
  cost[stateOf(graph, from, in)] = 0.0;
  bool changed = true;
  const auto offer = [&](std::size_t a, std::size_t b, double step) {
    if (!(cost[a] + step < cost[b] * (1.0 - 1e-9))) return;
    cost[b] = cost[a] + step;
    changed = true;
  };
  while (std::exchange(changed, false)) {
    for (int number = 0; number < static_cast<int>(graph.ltrs().size()); ++number) {
      const GraphLtr& ltr = graph.ltr(number);
      for (int a = 0; a < ltr.first_portal[3]; ++a) {
        const int portal = graph.portalAt(number, a);
        for (int b = 0; b < ltr.first_portal[3]; ++b) {
          const bool is_admitted =
              !admits ||
              admitsAll(graph, number, graph.wayBetween(number, portal, graph.portalAt(number, b)),
                        admits);
          if (!is_admitted) continue;
          offer(stateOf(graph, portal, number), stateOf(graph, graph.portalAt(number, b), number),
                ltr.factor * static_cast<double>(ltr.matrix->cost(a, b)));
        }
        const int k = graph.sideOf(portal);
        const std::size_t here = graph.side(k).ltrs[0] == number ? 0 : 1;
        offer(stateOf(graph, portal, number), stateOf(graph, portal, graph.side(k).ltrs[1 - here]),
              static_cast<double>(graph.crossing(graph.searchSide(k),
                                                 portal - graph.side(k).first_portal, 1 - here)));
      }
    }
  }
  return cost;
}

/// Discs in LTRs with factors of their own; in every other world heights that are dear to climb.
/// Deformed by less than what makes costs out of date: lengths have grown, costs have not.
struct UnevenWorld : World {
  explicit UnevenWorld(std::uint64_t seed) : World(freeGround, configOf(seed)) {
    RandomGenerator generator(seed);
    const Occupancy occupancy = discs(seed, 30, 48.0, {});
    for (const LtrView& ltr : mesh.ltrs) {
      LtrContent content = test::contentOf(ltr, occupancy);
      content.properties["height"] =
          test::contentOf(ltr, [](const Vector2d& p) {
            return static_cast<float>(3.0 * std::sin(0.2 * p.x()) * std::sin(0.15 * p.y()));
          }).occupancy;
      planner.setContent(ltr.id, content);
    }
    for (LtrView& ltr : mesh.ltrs) ltr.shape_factor = sampleUniform(generator, 1.0, 1.3);
    planner.setLtrs(mesh.ltrs);
    planner.prepare(Vector2d::Zero());
    const std::size_t matrices = planner.counts().matrices;
    test::Landmarks moved;
    for (const Vector2d& landmark : mesh.landmarks) moved.push_back(1.005 * landmark);
    mesh.moveTo(moved);
    planner.setLtrs(mesh.ltrs);
    planner.prepare(Vector2d::Zero());
    EXPECT_EQ(planner.counts().matrices, matrices);
    planner.prepareDistricts();
  }
  static DoorPlannerConfig configOf(std::uint64_t seed) {
    DoorPlannerConfig config;
    config.district_m = 10.0 + static_cast<double>(seed);
    if (seed % 2 == 0) config.cost.properties = "height climb 2";
    return config;
  }
};

/// What a route costs from its first portal to its last, LTR by LTR.
double costBetweenPortals(const DoorGraph& graph, const DoorRoute& route) {
  double sum = 0.0;
  const Waypoint* before = nullptr;
  for (const Waypoint& waypoint : route.waypoints) {
    if (waypoint.portal == kNone) continue;
    if (before != nullptr) {
      const int through = waypoint.place.ltr, from = before->portal;
      const int number = graph.sideOf(from);
      const GraphSide& side = graph.side(number);
      const std::size_t end = side.ltrs[0] == through ? 0 : 1;
      if (side.ltrs[end] != through) return kNoPassing;
      if (before->place.ltr != through) {
        sum += static_cast<double>(
            graph.crossing(graph.searchSide(number), from - side.first_portal, end));
      }
      sum += graph.ltr(through).factor *
             static_cast<double>(graph.ltr(through).matrix->cost(
                 graph.portalIn(through, from), graph.portalIn(through, waypoint.portal)));
    }
    before = &waypoint;
  }
  return sum;
}

TEST(DoorSearch, IsOptimalOverTheDoorGraphWithDistrictsAndWithout) {
  std::size_t crossed = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const UnevenWorld world(seed);
    const std::shared_ptr<const DoorGraph> graph = world.planner.graph();
    const std::shared_ptr<const Districts> districts = world.planner.districts();
    ASSERT_EQ(districts->missing(), 0U);
    ASSERT_GE(districts->count(), 9U);
    RandomGenerator generator(seed);
    DoorSearch search;
    for (int trial = 0; trial < 12; ++trial) {
      const auto portal = [&] {
        return static_cast<int>(sampleUniform(generator, 0.0, graph->portalCount()));
      };
      const auto placeAt = [&](int p) {
        const int ltr = graph->side(graph->sideOf(p)).ltrs[0];
        return GraphPlace{ltr, graph->localOf(ltr, p)};
      };
      const int from = portal(), to = portal();
      const GraphPlace start = placeAt(from), goal = placeAt(to);
      DoorRoute alone, together;
      const SearchOutcome outcome = search.find(*graph, start, goal, {}, alone);
      DoorSearch::Options options;
      options.districts = districts.get();
      ASSERT_EQ(search.find(*graph, start, goal, options, together), outcome);
      const double cheapest =
          cheapestAlongPortals(*graph, from, start.ltr)[stateOf(*graph, to, goal.ltr)];
      ASSERT_EQ(outcome == SearchOutcome::kFound, cheapest < kNoPassing);
      if (outcome != SearchOutcome::kFound) continue;
      EXPECT_LE(alone.cost, cheapest * (1.0 + 1e-5) + 1e-9);
      EXPECT_NEAR(together.cost, alone.cost, 1e-5 * alone.cost);
      EXPECT_LE(costBetweenPortals(*graph, together), together.cost * (1.0 + 1e-5) + 1e-9);
      crossed += together.expanded < alone.expanded ? 1 : 0;
    }
  }
  EXPECT_GT(crossed, 0U) << "no district was crossed at once";
}

TEST(PortalSearch, IsOptimalOverTheWaysThatAreAdmitted) {
  PortalSearch search;
  int reached = 0, dearer = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world(discs(seed, 15, 48.0, {}));
    const std::shared_ptr<const DoorGraph> graph = world.planner.graph();
    const Occupancy shunned = discs(seed + 100, 25, 48.0, {});
    PortalSearch::Scope scope;
    scope.graph = graph.get();
    scope.admits = [&](const Vector2d& place) { return shunned(place) < 0.5F; };
    for (int from = 0; from < graph->portalCount(); from += 41) {
      if (!scope.admits(graph->placeOf(from))) continue;
      const int ltr = graph->side(graph->sideOf(from)).ltrs[0];
      const std::vector<double> cheapest = cheapestAlongPortals(*graph, from, ltr, scope.admits);
      const std::vector<double> anyhow = cheapestAlongPortals(*graph, from, ltr);
      search.begin(scope, nullptr, nullptr);
      search.offerFrom(from, ltr);
      search.run();
      for (int to = 0; to < graph->portalCount(); ++to) {
        const double expected =
            std::min(cheapest[2 * std::size_t(to)], cheapest[2 * std::size_t(to) + 1]);
        if (!(expected < kNoPassing)) continue;
        EXPECT_NEAR(static_cast<double>(search.costTo(to)), expected, 1e-5 * expected + 1e-4)
            << "seed " << seed << ", from " << from << " to " << to;
        ++reached;
        dearer += expected > 1.001 * anyhow[2 * std::size_t(to)] ? 1 : 0;
      }
    }
  }
  EXPECT_GT(reached, 500);
  EXPECT_GT(dearer, 100) << "what is not admitted stands in no way's way";
}

TEST(DoorSearch, IsOptimalWhereSomeLtrsAreAThousandMillionTimesDearer) {
  DoorPlannerConfig config;
  config.cost.unknown = PathCostConfig::kDearest;
  config.district_m = 18.0;
  World world(freeGround, config);
  // Every third LTR is unknown, and uniform, so that nothing is searched inside of it.
  for (const LtrView& ltr : world.mesh.ltrs) {
    if (ltr.id % 3 == 0) world.planner.setContent(ltr.id, LtrContent());
  }
  world.planner.prepare(Vector2d::Zero());
  world.planner.prepareDistricts();
  const std::shared_ptr<const DoorGraph> graph = world.planner.graph();
  const std::shared_ptr<const Districts> districts = world.planner.districts();
  DoorSearch search;
  int dear = 0;
  for (int from = 0; from < graph->portalCount(); from += 31) {
    for (int to = 3; to < graph->portalCount(); to += 17) {
      const int ltr = graph->side(graph->sideOf(from)).ltrs[0];
      const int other = graph->side(graph->sideOf(to)).ltrs[0];
      const GraphPlace start{ltr, graph->localOf(ltr, from)},
          goal{other, graph->localOf(other, to)};
      const double cheapest = cheapestAlongPortals(*graph, from, ltr)[stateOf(*graph, to, other)];
      DoorRoute alone, together;
      DoorSearch::Options options;
      ASSERT_EQ(search.find(*graph, start, goal, options, alone), SearchOutcome::kFound);
      options.districts = districts.get();
      ASSERT_EQ(search.find(*graph, start, goal, options, together), SearchOutcome::kFound);
      EXPECT_LE(alone.cost, cheapest * (1.0 + 1e-5) + 1e-9);
      EXPECT_NEAR(together.cost, alone.cost, 1e-5 * alone.cost);
      dear += cheapest > 1e8 ? 1 : 0;
    }
  }
  EXPECT_GT(dear, 0) << "no way crosses dear ground";
}

}  // namespace
}  // namespace hymm::core
