#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "door_planner/ltr_view.h"

namespace hymm::core {

enum class PlanStatus {
  kOk,
  kNoMap,
  kBadRequest,
  kNoPath,
  kStartOccupied,
  kGoalOccupied,
  kStartOutsideMap,
  kGoalOutsideMap,
  kBelowInformation,
  kTimeout,
  kCancelled,
};

/// "OK", "NO_PATH", …
std::string nameOf(PlanStatus status);

struct PlanRequest {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  ///< in map, m
  Eigen::Vector2d goal = Eigen::Vector2d::Zero();
  /// Of the vehicle there, in map [rad], for a path that is refined; nothing: any.
  std::optional<double> start_heading, goal_heading;
  /// What a metre costs, in place of what is configured (PathCostConfig::with); empty: as that.
  std::string weights;
  bool is_refined = false;   ///< whether the path is to be one for a car with a turning radius
  double tolerance_m = 0.0;  ///< a start or goal that is occupied may be moved by this much
  /// Whether a place may be crossed: the level set of the lowest information to keep. None: all.
  std::function<bool(const Eigen::Vector2d&)> is_informed;
  /// Asked now and then; a status other than kOk ends the search with it.
  std::function<PlanStatus()> interrupted;
};

/// A point of a path by the landmarks around it: it moves as they do (6).
struct PlanPoint {
  int ltr = kNone;
  std::array<int, 3> landmark_ids{};
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< of the landmarks, sum 1
  bool is_backwards = false;                          ///< how a refined path comes to it
};

/// Answer to a request. `path` and the rest are of use if `status` is kOk.
struct Plan {
  PlanStatus status = PlanStatus::kNoMap;
  std::string sentence;  ///< what was found, or what went wrong and what to do
  std::vector<PlanPoint> points;
  std::vector<Eigen::Vector2d> path;   ///< the same in map, by the landmarks at planning time, m
  double cost = 0.0;                   ///< integral of mu along the path
  double cost_with_uncertainty = 0.0;  ///< each LTR's share times its K (19)
  double length_m = 0.0;
  double worst_shape_factor = 1.0;
  /// Whether the path is one for a car; if one was asked for and this is not, the sentence says
  /// why.
  bool is_refined = false;
  std::vector<std::uint64_t> doors;  ///< ids, in order, of the route that the path was pulled from
  std::size_t expanded_portals = 0;

  bool ok() const { return status == PlanStatus::kOk; }
};

/// Radius of the tightest circle through three points in a row that are driven in one gear, in map
/// as it was at planning time [m]; infinite if the path is straight.
double tightestRadius_m(const Plan& plan);

/// Heading of the vehicle at a point of a refined path [rad].
double headingAt(const Plan& plan, std::size_t point);

/// A plan's points where the landmarks are now; nothing if one of them is no more.
using LandmarkFinder = std::function<std::optional<Eigen::Vector2d>(int landmark)>;
std::optional<std::vector<Eigen::Vector2d>> placeOf(const std::vector<PlanPoint>& points,
                                                    const LandmarkFinder& find);

}  // namespace hymm::core
