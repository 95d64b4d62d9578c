// planner_optimality FIRST_SEED LAST_SEED [FOLDER]: plans across random worlds and compares with
// exhaustive search on a finer grid. Writes one line a world; with FOLDER, also what to draw.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "common/random.h"
#include "door_planner/door_planner.h"
#include "support/planner_meshes.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr double kExtent_m = 60.0;
constexpr double kFine_m = 0.1;
constexpr double kResolution_m = 0.2;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Discs that are occupied, patches that are unknown, and, in every other world, rough ground.
struct RandomWorld {
  explicit RandomWorld(std::uint64_t seed) : is_rough(seed % 2 == 0), generator(seed) {
    const int count = static_cast<int>(sampleUniform(generator, 20.0, 80.0));
    for (int i = 0; i < count; ++i) discs.push_back(disc(0.2, 2.5));
    for (int i = 0; i < 4; ++i) patches.push_back(disc(2.0, 6.0));
  }

  Eigen::Vector3d disc(double least_m, double most_m) {
    return {sampleUniform(generator, 0.0, kExtent_m), sampleUniform(generator, 0.0, kExtent_m),
            sampleUniform(generator, least_m, most_m)};
  }
  static bool anyContains(const std::vector<Eigen::Vector3d>& all, const Vector2d& p) {
    return std::any_of(all.begin(), all.end(), [&](const Eigen::Vector3d& d) {
      return (p - d.head<2>()).squaredNorm() < d.z() * d.z();
    });
  }
  float occupancy(const Vector2d& p) const {
    if (anyContains(discs, p)) return 1.0F;
    return anyContains(patches, p) ? NAN : 0.0F;
  }
  float roughness(const Vector2d& p) const {
    if (!is_rough) return 0.0F;
    return static_cast<float>(1.0 + std::sin(0.35 * p.x()) * std::cos(0.3 * p.y()));
  }

  bool is_rough;
  std::vector<Eigen::Vector3d> discs, patches;
  RandomGenerator generator;
};

/// What a metre costs at points of a fine grid, read from the planner's own cells: both searches
/// see the same ground.
class FineGrid {
 public:
  explicit FineGrid(const DoorGraph& graph) : values_(std::size_t(kCells) * kCells, kInfinite) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) values_[indexOf(x, y)] = costAt(graph, centreOf(x, y));
    }
  }

  static double costAt(const DoorGraph& graph, const Vector2d& place) {
    const int number = graph.locate(place);
    if (number == kNone) return kInfinite;
    const GraphLtr& ltr = graph.ltr(number);
    const int cell = ltr.costs->grid().index(ltr.triangle.toLocal(place));
    return ltr.costs->isPassable(cell) ? static_cast<double>(ltr.costs->perMetre(cell)) : kInfinite;
  }

  /// A* with 32 directions, the bound being the cheapest ground as the crow flies; then points are
  /// left out where a straight line costs no more. The cheaper of both costs.
  double search(const Vector2d& start, const Vector2d& goal, std::vector<Vector2d>& path) {
    const auto from = cellOf(start), to = cellOf(goal);
    const double least = *std::min_element(values_.begin(), values_.end());
    std::vector<double> costs(values_.size(), kInfinite);
    std::vector<int> parents(values_.size(), -1);
    std::vector<std::pair<double, int>> queue;
    const auto bound = [&](int cell) {
      return least * kFine_m * std::hypot(cell % kCells - to.first, cell / kCells - to.second);
    };
    const auto offer = [&](int cell, double cost, int parent) {
      if (cost >= costs[std::size_t(cell)]) return;
      costs[std::size_t(cell)] = cost;
      parents[std::size_t(cell)] = parent;
      queue.emplace_back(cost + bound(cell), cell);
      std::push_heap(queue.begin(), queue.end(), std::greater<>());
    };
    const int goal_cell = static_cast<int>(indexOf(to.first, to.second));
    offer(static_cast<int>(indexOf(from.first, from.second)), 0.0, -1);
    while (!queue.empty()) {
      std::pop_heap(queue.begin(), queue.end(), std::greater<>());
      const auto [total, cell] = queue.back();
      queue.pop_back();
      if (cell == goal_cell) break;
      if (total > costs[std::size_t(cell)] + bound(cell) + 1e-9) continue;
      const Vector2d here = centreOf(cell % kCells, cell / kCells);
      for (const auto& [dx, dy] : directions()) {
        const int x = cell % kCells + dx, y = cell / kCells + dy;
        if (x < 0 || y < 0 || x >= kCells || y >= kCells) continue;
        const double step = along(here, centreOf(x, y));
        if (step < kInfinite) {
          offer(static_cast<int>(indexOf(x, y)), costs[std::size_t(cell)] + step, cell);
        }
      }
    }
    if (costs[std::size_t(goal_cell)] == kInfinite) return kInfinite;
    for (int cell = goal_cell; cell >= 0; cell = parents[std::size_t(cell)]) {
      path.push_back(centreOf(cell % kCells, cell / kCells));
    }
    path.back() = start;
    path.front() = goal;
    std::reverse(path.begin(), path.end());
    return std::min(costs[std::size_t(goal_cell)], pull(path));
  }

 private:
  static constexpr int kCells = static_cast<int>(kExtent_m / kFine_m);

  static std::size_t indexOf(int x, int y) { return std::size_t(y) * kCells + std::size_t(x); }
  static Vector2d centreOf(int x, int y) { return {(x + 0.5) * kFine_m, (y + 0.5) * kFine_m}; }
  static std::pair<int, int> cellOf(const Vector2d& place) {
    return {static_cast<int>(place.x() / kFine_m), static_cast<int>(place.y() / kFine_m)};
  }
  static const std::vector<std::pair<int, int>>& directions() {
    static const std::vector<std::pair<int, int>> all = [] {
      std::vector<std::pair<int, int>> found;
      for (int x = -4; x <= 4; ++x) {
        for (int y = -4; y <= 4; ++y) {
          if (std::gcd(x, y) == 1 && std::abs(x) + std::abs(y) <= 5) found.emplace_back(x, y);
        }
      }
      return found;
    }();
    return all;
  }

  /// By samples every fifth of a cell.
  double along(const Vector2d& from, const Vector2d& to) const {
    const double length = (to - from).norm();
    const int parts = std::max(1, static_cast<int>(std::ceil(length / (0.2 * kFine_m))));
    double sum = 0.0;
    for (int i = 0; i < parts; ++i) {
      const auto [x, y] = cellOf(from + (to - from) * (i + 0.5) / parts);
      sum += values_[indexOf(x, y)];
    }
    return sum * length / parts;
  }

  double pull(std::vector<Vector2d>& path) const {
    std::vector<Vector2d> kept{path.front()};
    double total = 0.0;
    for (std::size_t anchor = 0; anchor + 1 < path.size();) {
      double cost = along(path[anchor], path[anchor + 1]);
      std::size_t reached = anchor + 1;
      double around = cost;
      for (std::size_t next = anchor + 2; next < path.size(); ++next) {
        around += along(path[next - 1], path[next]);
        const double straight = along(path[anchor], path[next]);
        if (straight > around + 1e-9) break;
        cost = around = straight;
        reached = next;
      }
      total += cost;
      kept.push_back(path[reached]);
      anchor = reached;
    }
    path = std::move(kept);
    return total;
  }

  std::vector<double> values_;
};

void writePath(const std::string& name, const std::vector<Vector2d>& path) {
  std::ofstream file(name);
  file << "x,y\n";
  for (const Vector2d& p : path) file << p.x() << ',' << p.y() << '\n';
}

void draw(const std::string& folder, std::uint64_t seed, const RandomWorld& world,
          const test::SquareMesh& mesh, const DoorGraph& graph, const Plan& plan,
          const std::vector<Vector2d>& reference) {
  const std::string stem = folder + "/" + std::to_string(seed) + "_";
  writePath(stem + "plan.csv", plan.path);
  writePath(stem + "reference.csv", reference);
  std::vector<Vector2d> portals;
  for (int i = 0; i < graph.portalCount(); ++i) portals.push_back(graph.placeOf(i));
  writePath(stem + "portals.csv", portals);
  std::ofstream sides(stem + "ltrs.csv");
  sides << "x1,y1,x2,y2,x3,y3\n";
  for (const LtrView& ltr : mesh.ltrs) {
    sides << ltr.corners[0].x() << ',' << ltr.corners[0].y() << ',' << ltr.corners[1].x() << ','
          << ltr.corners[1].y() << ',' << ltr.corners[2].x() << ',' << ltr.corners[2].y() << '\n';
  }
  std::ofstream ground(stem + "ground.csv");
  ground << "x,y,cost,occupancy\n";
  for (double y = 0.1; y < kExtent_m; y += 0.2) {
    for (double x = 0.1; x < kExtent_m; x += 0.2) {
      ground << x << ',' << y << ',' << FineGrid::costAt(graph, {x, y}) << ','
             << world.occupancy({x, y}) << '\n';
    }
  }
}

/// A mesh that reaches beyond the world on all sides.
test::SquareMesh meshOver(std::uint64_t seed) {
  test::SquareMesh mesh(5, 5, 14.0, kResolution_m, 2.0, seed);
  test::Landmarks shifted;
  for (const Vector2d& landmark : mesh.landmarks) shifted.push_back(landmark - Vector2d(5.0, 5.0));
  mesh.moveTo(shifted);
  return mesh;
}

void show(const RandomWorld& world, const test::SquareMesh& mesh, DoorPlanner& planner) {
  planner.setLtrs(mesh.ltrs);
  for (const LtrView& ltr : mesh.ltrs) {
    LtrContent content =
        test::contentOf(ltr, [&](const Vector2d& p) { return world.occupancy(p); });
    content.properties["roughness"] =
        test::contentOf(ltr, [&](const Vector2d& p) { return world.roughness(p); }).occupancy;
    planner.setContent(ltr.id, content);
  }
}

/// At a centre of the fine grid, so that it is free in both searches or in neither.
Vector2d drawFreePlace(const DoorGraph& graph, double low, double high,
                       RandomGenerator& generator) {
  Vector2d place;
  do {
    place.x() = sampleUniform(generator, low, high);
    place.y() = sampleUniform(generator, 3.0, kExtent_m - 3.0);
    place = kFine_m * ((place / kFine_m).array().floor().matrix() + Vector2d(0.5, 0.5));
  } while (FineGrid::costAt(graph, place) == kInfinite);
  return place;
}

template <class Work>
double wallTime_ms(Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

void run(std::uint64_t seed, const std::string& folder) {
  RandomWorld world(seed);
  const test::SquareMesh mesh = meshOver(seed);
  DoorPlannerConfig config;
  config.outside_is_occupied = false;  // the grid that it is compared with has no border either
  config.cost.properties = "roughness 0.5";
  DoorPlanner planner(config);
  show(world, mesh, planner);
  const double preparation_ms = wallTime_ms([&] { planner.prepare(Vector2d::Zero()); });
  const std::shared_ptr<const DoorGraph> graph = planner.graph();
  PlanRequest request;
  request.start = drawFreePlace(*graph, 3.0, 15.0, world.generator);
  request.goal = drawFreePlace(*graph, 45.0, 57.0, world.generator);
  Plan plan;
  const double query_ms = wallTime_ms([&] { plan = planner.plan(request); });
  std::vector<Vector2d> reference;
  const double optimum = FineGrid(*graph).search(request.start, request.goal, reference);
  std::printf("%llu,%s,%.6f,%.6f,%.3f,%.3f,%zu\n", static_cast<unsigned long long>(seed),
              nameOf(plan.status).c_str(), plan.ok() ? plan.cost : -1.0,
              optimum < kInfinite ? optimum : -1.0, query_ms,
              preparation_ms / static_cast<double>(mesh.ltrs.size()), plan.doors.size());
  if (!folder.empty()) draw(folder, seed, world, mesh, *graph, plan, reference);
}

}  // namespace
}  // namespace hymm::core

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: planner_optimality FIRST_SEED LAST_SEED [FOLDER]\n");
    return 2;
  }
  std::puts("seed,status,cost,optimum,query_ms,preparation_ms_per_ltr,doors");
  const auto last = std::strtoull(argv[2], nullptr, 10);
  for (auto seed = std::strtoull(argv[1], nullptr, 10); seed <= last; ++seed) {
    hymm::core::run(seed, argc > 3 ? argv[3] : "");
  }
  return 0;
}
