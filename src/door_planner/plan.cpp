#include "door_planner/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

/// Points nearer to each other tell nothing but rounding.
constexpr double kApart_m = 0.02;

Eigen::Vector2d chordTo(const Plan& plan, std::size_t point) {
  const Eigen::Vector2d along = (plan.path[point] - plan.path[point - 1]).normalized();
  return plan.points[point].is_backwards ? Eigen::Vector2d(-along) : along;
}

}  // namespace

std::string nameOf(PlanStatus status) {
  switch (status) {
    case PlanStatus::kOk:
      return "OK";
    case PlanStatus::kNoMap:
      return "NO_MAP";
    case PlanStatus::kBadRequest:
      return "BAD_REQUEST";
    case PlanStatus::kNoPath:
      return "NO_PATH";
    case PlanStatus::kStartOccupied:
      return "START_OCCUPIED";
    case PlanStatus::kGoalOccupied:
      return "GOAL_OCCUPIED";
    case PlanStatus::kStartOutsideMap:
      return "START_OUTSIDE_MAP";
    case PlanStatus::kGoalOutsideMap:
      return "GOAL_OUTSIDE_MAP";
    case PlanStatus::kBelowInformation:
      return "BELOW_INFORMATION";
    case PlanStatus::kTimeout:
      return "TIMEOUT";
    case PlanStatus::kCancelled:
      return "CANCELLED";
  }
  return "UNKNOWN";
}

double tightestRadius_m(const Plan& plan) {
  double tightest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i + 1 < plan.path.size(); ++i) {
    if (plan.points[i].is_backwards != plan.points[i + 1].is_backwards) continue;
    const Eigen::Vector2d in = plan.path[i] - plan.path[i - 1];
    const Eigen::Vector2d out = plan.path[i + 1] - plan.path[i];
    if (std::min(in.norm(), out.norm()) < kApart_m) continue;
    const double twice_area = std::abs(in.x() * out.y() - in.y() * out.x());
    const double radius =
        in.norm() * out.norm() * (in + out).norm() / std::max(2.0 * twice_area, 1e-12);
    tightest = std::min(tightest, radius);
  }
  return tightest;
}

double headingAt(const Plan& plan, std::size_t point) {
  if (plan.path.size() < 2) return 0.0;
  // The tangent of a circle through three points, if they are equally far apart.
  Eigen::Vector2d along = chordTo(plan, std::max<std::size_t>(point, 1));
  if (point > 0 && point + 1 < plan.path.size()) along += chordTo(plan, point + 1);
  return std::atan2(along.y(), along.x());
}

std::optional<std::vector<Eigen::Vector2d>> placeOf(const std::vector<PlanPoint>& points,
                                                    const LandmarkFinder& find) {
  std::vector<Eigen::Vector2d> places;
  places.reserve(points.size());
  for (const PlanPoint& point : points) {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<Eigen::Vector2d> landmark = find(point.landmark_ids[k]);
      if (!landmark) return std::nullopt;
      place += point.weights[Eigen::Index(k)] * *landmark;
    }
    places.push_back(place);
  }
  return places;
}

}  // namespace hymm::core
