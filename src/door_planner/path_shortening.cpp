#include "door_planner/path_shortening.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
bool PathShortening::dropPoints(Draft& draft) const {
  const auto& [path, costs, stale] = draft;
  Draft kept{{path.front()}, {}, {stale.front()}};
  bool dropped = false;
  for (std::size_t i = 0; i + 1 < path.size();) {
    char again = stale[i + 1];
    if (i + 2 < path.size() && again != 0) {
      const double straight = cost(path[i], path[i + 2]);
      if (straight < kNoPassing && straight <= (costs[i] + costs[i + 1]) * (1.0 + kRounding)) {
        kept.stale.back() = 1;
        kept.path.push_back(path[i + 2]);
        kept.costs.push_back(straight);
        kept.stale.push_back(1);
        dropped = true;
        i += 2;
        continue;
      }
      again = 0;
    }
    kept.path.push_back(path[i + 1]);
    kept.costs.push_back(costs[i]);
    kept.stale.push_back(again);
    ++i;
  }
  draft = std::move(kept);
  return dropped;
}

bool PathShortening::movePoint(Draft& draft, std::size_t i, double step_m) const {
  const std::vector<PathPoint>& path = draft.path;
  const Eigen::Vector2d here = path[i].position;
  const Eigen::Vector2d chord = 0.5 * (path[i - 1].position + path[i + 1].position) - here;
  // Towards the straight line between the points beside it.
  const Eigen::Vector2d line = (path[i + 1].position - path[i - 1].position).normalized();
  Eigen::Vector2d inward = chord - chord.dot(line) * line;
  const double distance = inward.norm();
  if (distance < 1e-6) return false;
  inward *= std::min(step_m, distance) / distance;
  PathPoint tried{here + inward, kNone};
  tried.ltr = graph_.locate(tried.position);
  if (tried.ltr == kNone) return false;
  const double now = draft.costs[i - 1] + draft.costs[i];
  const double before = cost(path[i - 1], tried);
  if (!(before < now)) return false;
  const double after = cost(tried, path[i + 1]);
  if (!(before + after < now * (1.0 - 1e-7))) return false;
  draft.path[i] = tried;
  draft.costs[i - 1] = before;
  draft.costs[i] = after;
  return true;
}

bool PathShortening::movePoints(Draft& draft, double step_m) const {
  bool any = false;
  for (std::size_t i = 1; i + 1 < draft.path.size(); ++i) {
    if (draft.stale[i] == 0) continue;
    draft.stale[i] = 0;
    if (!movePoint(draft, i, step_m)) continue;
    std::fill_n(draft.stale.begin() + std::ptrdiff_t(i) - 1, 3, char{1});
    any = true;
  }
  return any;
}

double PathShortening::shorten(std::vector<PathPoint>& path) const {
  Draft draft{path, {}, std::vector<char>(path.size(), 1)};
  for (std::size_t i = 1; i < path.size(); ++i) draft.costs.push_back(cost(path[i - 1], path[i]));
  while (dropPoints(draft)) {
  }
  for (double step_m = kFirstMove_m; step_m > kLastMove_m; step_m *= 0.5) {
    std::fill(draft.stale.begin(), draft.stale.end(), char{1});
    for (int pass = 0; pass < 4 && movePoints(draft, step_m); ++pass) {
    }
    std::fill(draft.stale.begin(), draft.stale.end(), char{1});
    dropPoints(draft);
  }
  path = std::move(draft.path);
  return std::accumulate(draft.costs.begin(), draft.costs.end(), 0.0);
}

}  // namespace hymm::core
