#include "door_planner/path_shortening.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hymm::core {
namespace {

constexpr double kRounding = 1e-9;
constexpr double kFirstMove_m = 1.0;
constexpr double kAllowedEvery_m = 0.25;
constexpr double kLastMove_m = 0.1;

}  // namespace

double PathShortening::cost(const PathPoint& from, const PathPoint& to) const {
  if (allows_) {
    const Eigen::Vector2d along = to.position - from.position;
    const int parts = static_cast<int>(std::ceil(along.norm() / kAllowedEvery_m));
    for (int i = 1; i < parts; ++i) {
      if (!allows_(from.position + along * i / parts)) return kNoPassing;
    }
  }
  return graph_.integrateFromAny(from.ltr, from.position, to.position);
}

// Every other point is tried, so that one pass costs two traversals of the path, and halves its
// points where nothing is in the way.
bool PathShortening::dropPoints(std::vector<PathPoint>& path, std::vector<double>& costs) const {
  std::vector<PathPoint> kept{path.front()};
  std::vector<double> kept_costs;
  std::size_t i = 0;
  while (i + 1 < path.size()) {
    if (i + 2 < path.size()) {
      const double straight = cost(path[i], path[i + 2]);
      if (straight < kNoPassing && straight <= (costs[i] + costs[i + 1]) * (1.0 + kRounding)) {
        kept.push_back(path[i + 2]);
        kept_costs.push_back(straight);
        i += 2;
        continue;
      }
    }
    kept.push_back(path[i + 1]);
    kept_costs.push_back(costs[i]);
    ++i;
  }
  const bool dropped = kept.size() < path.size();
  path = std::move(kept);
  costs = std::move(kept_costs);
  return dropped;
}

bool PathShortening::movePoints(std::vector<PathPoint>& path, std::vector<double>& costs,
                                double step_m) const {
  bool moved = false;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Eigen::Vector2d& here = path[i].position;
    const Eigen::Vector2d chord = 0.5 * (path[i - 1].position + path[i + 1].position) - here;
    // Towards the straight line between the points beside it.
    const Eigen::Vector2d line = (path[i + 1].position - path[i - 1].position).normalized();
    Eigen::Vector2d inward = chord - chord.dot(line) * line;
    const double distance = inward.norm();
    if (distance < 1e-6) continue;
    inward *= std::min(step_m, distance) / distance;
    PathPoint tried{here + inward, kNone};
    tried.ltr = graph_.locate(tried.position);
    if (tried.ltr == kNone) continue;
    const double before = cost(path[i - 1], tried);
    if (!(before < costs[i - 1] + costs[i])) continue;
    const double after = cost(tried, path[i + 1]);
    if (!(before + after < (costs[i - 1] + costs[i]) * (1.0 - 1e-7))) continue;
    path[i] = tried;
    costs[i - 1] = before;
    costs[i] = after;
    moved = true;
  }
  return moved;
}

double PathShortening::shorten(std::vector<PathPoint>& path) const {
  std::vector<double> costs;
  for (std::size_t i = 1; i < path.size(); ++i) costs.push_back(cost(path[i - 1], path[i]));
  while (dropPoints(path, costs)) {
  }
  for (double step_m = kFirstMove_m; step_m > kLastMove_m; step_m *= 0.5) {
    for (int pass = 0; pass < 4 && movePoints(path, costs, step_m); ++pass) {
    }
    dropPoints(path, costs);
  }
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

}  // namespace hymm::core
