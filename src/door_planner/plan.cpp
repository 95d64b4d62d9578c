#include "door_planner/plan.h"

namespace hymm::core {

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
