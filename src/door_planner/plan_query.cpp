#include "door_planner/plan_query.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <utility>

#include "door_planner/path_refinement.h"

namespace hymm::core {
namespace {

/// Directions and steps in which a place that is free is looked for around one that is not.
constexpr int kSpokes = 16;
constexpr double kSpokeStep_m = 0.1;
/// Between questions whether to go on: some thousand places.
constexpr std::int64_t kStepsBetweenStops = 256;

std::string placeText(const Eigen::Vector2d& place) {
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "(" << place.x() << ", " << place.y() << ")";
  return text.str();
}

bool isFinite(const std::optional<double>& number) { return !number || std::isfinite(*number); }

/// How far away what a graph's LTRs cover begins, and ends, at most.
std::pair<double, double> distancesTo(const DoorGraph& graph, const Eigen::Vector2d& point) {
  Eigen::Vector2d low = graph.ltrs().front().view.corners[0], high = low;
  for (const GraphLtr& ltr : graph.ltrs()) {
    for (const Eigen::Vector2d& corner : ltr.view.corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const Eigen::Vector2d nearest = point.cwiseMax(low).cwiseMin(high);
  const Eigen::Vector2d farthest = (point - low).cwiseAbs().cwiseMax((point - high).cwiseAbs());
  return {(point - nearest).norm(), farthest.norm()};
}

}  // namespace

Plan refusedPlan(PlanStatus status, const std::string& sentence) {
  Plan plan;
  plan.status = status;
  plan.sentence = sentence;
  return plan;
}

Plan PlanQuery::run(DoorSearch& search) {
  if (std::optional<Plan> refused = check()) return *refused;
  DoorSearch::Options options;
  options.admits = request_.is_informed;
  options.districts = districts_;
  if (request_.interrupted) options.stop = [this] { return isInterrupted(); };
  if (isInterrupted()) return stopped();
  DoorRoute route;
  const SearchOutcome outcome = search.find(graph_, start_, goal_, options, route);
  if (outcome == SearchOutcome::kStopped) return stopped();
  if (outcome == SearchOutcome::kNoWay) return noWay(search);
  return join(route);
}

std::optional<Plan> PlanQuery::check() {
  if (!request_.start.allFinite() || !request_.goal.allFinite() ||
      !isFinite(request_.start_heading) || !isFinite(request_.goal_heading) ||
      !std::isfinite(request_.tolerance_m) || request_.tolerance_m < 0.0) {
    return refusedPlan(PlanStatus::kBadRequest,
                       "Start, goal and tolerance must be finite, and the tolerance not negative.");
  }
  if (graph_.ltrs().empty()) {
    return refusedPlan(PlanStatus::kNoMap,
                       "There is no map yet: no local triangular region has been received.");
  }
  if (std::optional<Plan> refused = place("start", request_.start, PlanStatus::kStartOutsideMap,
                                          PlanStatus::kStartOccupied, start_)) {
    return refused;
  }
  return place("goal", request_.goal, PlanStatus::kGoalOutsideMap, PlanStatus::kGoalOccupied,
               goal_);
}

bool PlanQuery::isInformed(const Eigen::Vector2d& point) const {
  return !request_.is_informed || request_.is_informed(point);
}

bool PlanQuery::isInterrupted() {
  if (request_.interrupted) interruption_ = request_.interrupted();
  return interruption_ != PlanStatus::kOk;
}

GraphPlace PlanQuery::locate(const Eigen::Vector2d& point) const {
  GraphPlace place;
  place.ltr = graph_.locate(point);
  if (place.ltr != kNone) place.local = graph_.ltr(place.ltr).triangle.toLocal(point);
  return place;
}

bool PlanQuery::isFree(const GraphPlace& place) const {
  return place.ltr != kNone && graph_.isPassable(place.ltr, place.local);
}

std::optional<GraphPlace> PlanQuery::freeAt(const Eigen::Vector2d& point) const {
  const GraphPlace place = locate(point);
  if (isFree(place) && isInformed(point)) return place;
  return std::nullopt;
}

/// The nearest free place within the tolerance, found along spokes. Whatever the tolerance, it is
/// looked for no farther than LTRs reach.
std::optional<GraphPlace> PlanQuery::nearestFree(const Eigen::Vector2d& point) {
  if (std::optional<GraphPlace> free = freeAt(point)) return free;
  const auto [nearest_m, farthest_m] = distancesTo(graph_, point);
  const double first = std::max(1.0, std::floor(nearest_m / kSpokeStep_m));
  // A tolerance of whole steps holds as many, whatever a quotient's last digit says.
  const double last = std::floor(std::min(request_.tolerance_m, farthest_m) / kSpokeStep_m + 1e-6);
  if (!(first <= last)) return std::nullopt;
  // Counted by whole numbers: far from the map a step is less than a distance's last digit.
  const auto steps = static_cast<std::int64_t>(last - first);
  for (std::int64_t step = 0; step <= steps; ++step) {
    if (step % kStepsBetweenStops == 0 && isInterrupted()) return std::nullopt;
    const double away_m = (first + static_cast<double>(step)) * kSpokeStep_m;
    for (int i = 0; i < kSpokes; ++i) {
      const double angle = 2.0 * M_PI * i / kSpokes;
      const Eigen::Vector2d spoke(std::cos(angle), std::sin(angle));
      if (std::optional<GraphPlace> free = freeAt(point + away_m * spoke)) return free;
    }
  }
  return std::nullopt;
}

std::optional<Plan> PlanQuery::place(const std::string& what, const Eigen::Vector2d& point,
                                     PlanStatus outside, PlanStatus occupied, GraphPlace& found) {
  const std::string where = "The " + what + " " + placeText(point);
  if (std::optional<GraphPlace> free = nearestFree(point)) {
    found = *free;
    return std::nullopt;
  }
  if (interruption_ != PlanStatus::kOk) return stopped();
  const GraphPlace exact = locate(point);
  if (exact.ltr == kNone) {
    return refusedPlan(outside, where +
                                    " lies outside of every local triangular region; drive there "
                                    "first, or ask for a place inside the map.");
  }
  if (!graph_.ltr(exact.ltr).costs) {
    return refusedPlan(outside,
                       where + " lies in a region whose cells have not been received yet.");
  }
  if (isFree(exact)) {
    return refusedPlan(
        PlanStatus::kBelowInformation,
        where + " lies where the vehicle would know its pose less well than asked for.");
  }
  return refusedPlan(occupied,
                     where +
                         " is occupied, or too near to something that is, or to the border of the "
                         "map, for the vehicle's width; a larger tolerance lets it be moved.");
}

Plan PlanQuery::stopped() const {
  if (interruption_ == PlanStatus::kCancelled) {
    return refusedPlan(interruption_, "The request was cancelled.");
  }
  return refusedPlan(interruption_, "No path was found within the time that was given.");
}

/// Tells whether there would be a way if no information were asked for.
Plan PlanQuery::noWay(DoorSearch& search) {
  const std::string between =
      "from " + placeText(request_.start) + " to " + placeText(request_.goal);
  if (request_.is_informed) {
    if (isInterrupted()) return stopped();
    DoorSearch::Options options;
    options.districts = districts_;
    if (request_.interrupted) options.stop = [this] { return isInterrupted(); };
    DoorRoute route;
    const SearchOutcome outcome = search.find(graph_, start_, goal_, options, route);
    if (outcome == SearchOutcome::kStopped) return stopped();
    if (outcome == SearchOutcome::kFound) {
      return refusedPlan(PlanStatus::kBelowInformation,
                         "Every way " + between +
                             " leads through places where the vehicle would know its pose less "
                             "well than asked for; ask for less information.");
    }
  }
  return refusedPlan(PlanStatus::kNoPath,
                     "No way leads " + between +
                         " through doors that are wide enough: they lie in parts of the map that "
                         "are not connected for this vehicle.");
}

Plan PlanQuery::join(const DoorRoute& route) {
  std::vector<PathPoint> path;
  Plan plan;
  plan.status = PlanStatus::kOk;
  plan.expanded_portals = route.expanded;
  for (const Waypoint& waypoint : route.waypoints) {
    const GraphLtr& ltr = graph_.ltr(waypoint.place.ltr);
    path.push_back({ltr.triangle.toGlobal(waypoint.place.local), waypoint.place.ltr});
    plan.worst_shape_factor = std::max(plan.worst_shape_factor, ltr.factor);
  }
  if (PathShortening(graph_, request_.is_informed).shorten(path) == kNoPassing) {
    return refusedPlan(
        request_.is_informed ? PlanStatus::kBelowInformation : PlanStatus::kNoPath,
        "The way along doors that was found is not free between them; ask again when the map has "
        "changed.");
  }
  std::uint64_t last_door = 0;
  for (const int portal : route.portals) {
    const std::uint64_t door = graph_.doorOf(portal);
    if (door != last_door) plan.doors.push_back(door);
    last_door = door;
  }
  std::string remark;
  if (request_.is_refined) remark = refine(path, plan);
  if (interruption_ == PlanStatus::kCancelled) return stopped();
  describe(path, plan);
  plan.sentence += remark;
  return plan;
}

/// Replaces the path by one for a car, or tells why it is left as it is.
std::string PlanQuery::refine(std::vector<PathPoint>& path, Plan& plan) {
  PathRefinement::Request request;
  request.start_heading = request_.start_heading;
  request.goal_heading = request_.goal_heading;
  request.allows = request_.is_informed;
  if (request_.interrupted) request.stop = [this] { return isInterrupted(); };
  const PathRefinement::Outcome outcome =
      PathRefinement(graph_, config_.vehicle, config_.refinement).refine(path, request);
  if (outcome.poses.empty()) {
    return " It is not refined for the turning radius: " + outcome.failure + ".";
  }
  path.clear();
  for (const CarPose& pose : outcome.poses) {
    const Eigen::Vector2d place = pose.T_map_base.position();
    path.push_back({place, graph_.locate(place)});
    plan.points.emplace_back();
    plan.points.back().is_backwards = pose.is_backwards;
  }
  plan.is_refined = true;
  return " It respects the turning radius.";
}

void PlanQuery::describe(const std::vector<PathPoint>& path, Plan& plan) const {
  plan.points.resize(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const GraphLtr& ltr = graph_.ltr(path[i].ltr);
    plan.path.push_back(path[i].position);
    plan.points[i].ltr = ltr.view.id;
    plan.points[i].landmark_ids = ltr.view.landmark_ids;
    plan.points[i].weights = Triangle::weights(ltr.triangle.toLocal(path[i].position));
    if (i == 0) continue;
    const PathPoint& before = path[i - 1];
    plan.cost += graph_.integrateFromAny(before.ltr, before.position, path[i].position, false);
    plan.cost_with_uncertainty +=
        graph_.integrateFromAny(before.ltr, before.position, path[i].position);
    plan.length_m += (path[i].position - before.position).norm();
  }
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "A path of " << plan.length_m << " m through " << plan.doors.size()
       << " doors.";
  plan.sentence = text.str();
}

}  // namespace hymm::core
