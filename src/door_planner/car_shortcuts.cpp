#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "door_planner/path_refinement.h"

namespace hymm::core {
namespace {

/// Lengths of the stretches that a curve is tried for, from far to near; the first is all of it.
constexpr std::array<double, 7> kSpans_m{1e6, 80.0, 40.0, 20.0, 12.0, 8.0, 4.0};
/// They are tried at every such share of their length.
constexpr double kStride = 0.125;
constexpr int kSweeps = 2;
constexpr double kGain_m = 0.01;  ///< from which a curve is worth it

}  // namespace

/// A path for a car, and what it costs from its start to each pose, changes of direction included.
struct PathRefinement::Drive {
  std::vector<CarPose> poses;
  std::vector<double> along_m, cost;

  bool changesDirectionAfter(std::size_t i, bool is_backwards) const {
    return i + 1 < poses.size() && poses[i + 1].is_backwards != is_backwards;
  }
  std::size_t poseAt(double at_m) const {
    const auto next = std::lower_bound(along_m.begin(), along_m.end(), at_m);
    return std::min(static_cast<std::size_t>(next - along_m.begin()), poses.size() - 1);
  }
};

void PathRefinement::measure(Drive& drive) const {
  drive.along_m.assign(1, 0.0);
  drive.cost.assign(1, 0.0);
  int ltr = graph_.locate(drive.poses.front().T_map_base.position());
  for (std::size_t i = 1; i < drive.poses.size(); ++i) {
    const Eigen::Vector2d before = drive.poses[i - 1].T_map_base.position();
    const Eigen::Vector2d here = drive.poses[i].T_map_base.position();
    double step = graph_.integrateFromAny(ltr, before, here);
    if (i > 1 && drive.changesDirectionAfter(i - 1, drive.poses[i - 1].is_backwards)) {
      step += changeCost();
    }
    drive.along_m.push_back(drive.along_m.back() + (here - before).norm());
    drive.cost.push_back(drive.cost.back() + step);
    if (!graph_.ltr(ltr).triangle.contains(here)) ltr = graph_.locate(here);
  }
}

/// Puts the shortest curve between two poses in the place of what lies between, if it is free and
/// cheaper.
bool PathRefinement::cut(Drive& drive, std::size_t from, std::size_t to,
                         const Request& request) const {
  const CarPose &begin = drive.poses[from], &end = drive.poses[to];
  double now = drive.cost[to] - drive.cost[from];
  if (drive.changesDirectionAfter(to, end.is_backwards)) now += changeCost();
  const double enough = now - kGain_m * graph_.leastPerMetre();
  const CarCurve curve = space_.shortest(begin.T_map_base, end.T_map_base);
  const double at_least =
      graph_.leastPerMetre() * curve.length() + changeCost() * curve.directionChanges();
  if (curve.pieces.empty() || at_least >= enough) return false;
  std::vector<CarPose> way = curve.poses(config_.step_m);
  double cost = costOf(way, begin.T_map_base, request);
  if (from > 0 && way.front().is_backwards != begin.is_backwards) cost += changeCost();
  if (drive.changesDirectionAfter(to, way.back().is_backwards)) cost += changeCost();
  if (!(cost < enough)) return false;
  const auto first = drive.poses.begin() + std::ptrdiff_t(from) + 1;
  const auto rest = drive.poses.erase(first, drive.poses.begin() + std::ptrdiff_t(to) + 1);
  drive.poses.insert(rest, way.begin(), way.end());
  measure(drive);
  return true;
}

void PathRefinement::shorten(std::vector<CarPose>& poses, const Request& request) const {
  if (poses.size() < 3) return;
  Drive drive;
  drive.poses = std::move(poses);
  measure(drive);
  bool is_stopped = false, has_changed = true;
  for (int sweep = 0; sweep < kSweeps && has_changed && !is_stopped; ++sweep) {
    has_changed = false;
    for (const double span_m : kSpans_m) {
      const double stride_m = kStride * span_m;
      for (double at_m = 0.0; at_m < drive.along_m.back() && !is_stopped; at_m += stride_m) {
        const std::size_t from = drive.poseAt(at_m), to = drive.poseAt(at_m + span_m);
        is_stopped = request.stop && request.stop();
        if (!is_stopped && from + 1 < to)
          has_changed = cut(drive, from, to, request) || has_changed;
      }
    }
  }
  poses = std::move(drive.poses);
}

}  // namespace hymm::core
