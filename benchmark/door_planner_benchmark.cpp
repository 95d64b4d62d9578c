// Path queries over LTRs beside A* on a grid of the same world and resolution, and what it costs
// the door planner to be ready for them.

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "benchmark/benchmarks.h"
#include "benchmark/disc_world.h"
#include "benchmark/grid_astar.h"
#include "common/random.h"
#include "door_planner/door_planner.h"

namespace hymm::benchmarks {
namespace {

using Eigen::Vector2d;

constexpr double kResolution_m = 0.2;
constexpr int kQueries = 8;
constexpr double kSpread = 0.1;  ///< of the extent, in which starts and goals lie

double secondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// From one corner to the opposite one, at places with room around them.
std::vector<std::pair<Vector2d, Vector2d>> queriesIn(const DiscWorld& world) {
  core::RandomGenerator generator(2);
  const auto placeFrom = [&](double low) {
    Vector2d place;
    do {
      place.x() = low + core::sampleUniform(generator, 2.0, kSpread * world.extent_m());
      place.y() = low + core::sampleUniform(generator, 2.0, kSpread * world.extent_m());
    } while (world.clearance(place, 3.0) < 2.0);
    return place;
  };
  std::vector<std::pair<Vector2d, Vector2d>> queries;
  for (int i = 0; i < kQueries; ++i) {
    const Vector2d start = placeFrom(0.0);
    queries.emplace_back(start, placeFrom((1.0 - kSpread) * world.extent_m() - 4.0));
  }
  return queries;
}

double meanDistance(const std::vector<std::pair<Vector2d, Vector2d>>& queries) {
  double sum = 0.0;
  for (const auto& [start, goal] : queries) sum += (goal - start).norm();
  return sum / static_cast<double>(queries.size());
}

/// A planner that knows the world, and what it took to make it.
struct PreparedPlanner {
  explicit PreparedPlanner(int cells)
      : world(cells * kResolution_m, 1), mesh(meshOver(world, kResolution_m)), planner({}) {
    planner.setLtrs(mesh.ltrs);
    for (const core::LtrView& ltr : mesh.ltrs) planner.setContent(ltr.id, world.contentOf(ltr));
    const auto begin = std::chrono::steady_clock::now();
    planner.prepare(Vector2d::Zero());
    preparation_s = secondsSince(begin);
    const auto districts_begin = std::chrono::steady_clock::now();
    planner.prepareDistricts();
    districts_s = secondsSince(districts_begin);
  }

  DiscWorld world;
  test::SquareMesh mesh;
  core::DoorPlanner planner;
  double preparation_s = 0.0, districts_s = 0.0;
};

PreparedPlanner& plannerOf(int cells) {
  static std::map<int, std::unique_ptr<PreparedPlanner>> planners;
  std::unique_ptr<PreparedPlanner>& prepared = planners[cells];
  if (!prepared) {
    planners.clear();
    planners[cells] = std::make_unique<PreparedPlanner>(cells);
    return *planners[cells];
  }
  return *prepared;
}

void queryDoors(benchmark::State& state, int cells) {
  const PreparedPlanner& prepared = plannerOf(cells);
  const auto queries = queriesIn(prepared.world);
  double cost = 0.0, expanded = 0.0;
  std::size_t count = 0;
  for (auto _ : state) {
    core::PlanRequest request;
    std::tie(request.start, request.goal) = queries[count % queries.size()];
    const core::Plan plan = prepared.planner.plan(request);
    if (!plan.ok()) throw std::runtime_error("BM_DoorPlannerQuery: " + plan.sentence);
    cost += plan.cost;
    expanded += static_cast<double>(plan.expanded_portals);
    ++count;
  }
  const auto graph = prepared.planner.graph();
  const auto ltrs = static_cast<double>(graph->ltrs().size());
  state.counters["cost"] = cost / static_cast<double>(count);
  state.counters["distance_m"] = meanDistance(queries);
  state.counters["expanded"] = expanded / static_cast<double>(count);
  state.counters["ltrs"] = ltrs;
  state.counters["portals"] = graph->portalCount();
  state.counters["preparation_s"] = prepared.preparation_s;
  state.counters["districts_s"] = prepared.districts_s;
  state.counters["district_bytes_per_ltr"] =
      static_cast<double>(prepared.planner.districts()->bytes()) / ltrs;
  state.counters["bytes_per_ltr"] = static_cast<double>(graph->bytes()) / ltrs;
}

void queryGrid(benchmark::State& state, int cells) {
  const DiscWorld world(cells * kResolution_m, 1);
  GridAStar grid(cells, kResolution_m);
  const double half_width_m = 0.5 * core::DoorPlannerConfig().vehicle.width_m;
  for (const DiscWorld::Disc& disc : world.discs()) {
    const double reach = disc.radius_m + half_width_m;
    const auto cellOf = [&](double coordinate) {
      return std::min(std::max(0, static_cast<int>(coordinate / kResolution_m)), cells - 1);
    };
    for (int y = cellOf(disc.centre.y() - reach); y <= cellOf(disc.centre.y() + reach); ++y) {
      for (int x = cellOf(disc.centre.x() - reach); x <= cellOf(disc.centre.x() + reach); ++x) {
        const Vector2d centre((x + 0.5) * kResolution_m, (y + 0.5) * kResolution_m);
        if ((centre - disc.centre).norm() < reach) grid.block(x, y);
      }
    }
  }
  const auto queries = queriesIn(world);
  double cost = 0.0;
  std::size_t count = 0;
  for (auto _ : state) {
    const auto& [start, goal] = queries[count++ % queries.size()];
    cost += grid.find(start, goal);
  }
  state.counters["cost"] = cost / static_cast<double>(count);
  state.counters["distance_m"] = meanDistance(queries);
}

/// One LTR in the middle changes what it holds: until queries use it.
void changeLtr(benchmark::State& state, int cells) {
  PreparedPlanner& prepared = plannerOf(cells);
  const std::size_t middle = prepared.mesh.ltrs.size() / 2 + prepared.mesh.ltrs.size() / 200;
  const core::LtrView& ltr = prepared.mesh.ltrs[middle];
  const core::LtrContent before = prepared.world.contentOf(ltr);
  core::LtrContent after = before;
  const core::TriangularGrid grid = core::gridOf(ltr.alpha_cells, ltr.beta_cells);
  for (int i = 20; i < 24; ++i) {
    for (int j = 20; j < 24; ++j) after.occupancy[std::size_t(grid.index(i, j))] = 1.0F;
  }
  bool is_changed = false;
  for (auto _ : state) {
    prepared.planner.setContent(ltr.id, is_changed ? before : after);
    prepared.planner.prepare(Vector2d::Zero());
    is_changed = !is_changed;
  }
  state.counters["ltrs"] = static_cast<double>(prepared.mesh.ltrs.size());
}

}  // namespace

void registerDoorPlannerBenchmarks(Registration& registration) {
  const auto in_milliseconds = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMillisecond);
  };
  for (const int cells : {1000, 4000, 10000}) {
    const std::string suffix = "/" + std::to_string(cells);
    registration.add(
        "BM_DoorPlannerQuery" + suffix,
        [cells](benchmark::State& state) { queryDoors(state, cells); }, in_milliseconds);
    registration.add(
        "BM_DoorPlannerChange" + suffix,
        [cells](benchmark::State& state) { changeLtr(state, cells); }, in_milliseconds);
    registration.add(
        "BM_GridAStarQuery" + suffix, [cells](benchmark::State& state) { queryGrid(state, cells); },
        in_milliseconds);
  }
}

}  // namespace hymm::benchmarks
