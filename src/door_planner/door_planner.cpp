#include "door_planner/door_planner.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "door_planner/path_shortening.h"

namespace hymm::core {
namespace {

/// Directions and steps in which a place that is free is looked for around one that is not.
constexpr int kSpokes = 16;
constexpr double kSpokeStep_m = 0.1;

std::string placeText(const Eigen::Vector2d& place) {
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "(" << place.x() << ", " << place.y() << ")";
  return text.str();
}

Plan failed(PlanStatus status, const std::string& sentence) {
  Plan plan;
  plan.status = status;
  plan.sentence = sentence;
  return plan;
}

/// One query against one graph.
class Query {
 public:
  Query(const DoorGraph& graph, const PlanRequest& request) : graph_(graph), request_(request) {}

  Plan run(DoorSearch& search) {
    if (std::optional<Plan> refused = check()) return *refused;
    DoorSearch::Options options;
    options.admits = request_.is_informed;
    PlanStatus interruption = PlanStatus::kOk;
    if (request_.interrupted) {
      options.stop = [&] {
        interruption = request_.interrupted();
        return interruption != PlanStatus::kOk;
      };
      if (options.stop()) return stopped(interruption);
    }
    DoorRoute route;
    const SearchOutcome outcome = search.find(graph_, start_, goal_, options, route);
    if (outcome == SearchOutcome::kStopped) return stopped(interruption);
    if (outcome == SearchOutcome::kNoWay) return noWay(search);
    return describe(route);
  }

 private:
  std::optional<Plan> check() {
    if (!request_.start.allFinite() || !request_.goal.allFinite() ||
        !(request_.tolerance_m >= 0.0)) {
      return failed(PlanStatus::kBadRequest,
                    "Start and goal must be finite and the tolerance not negative.");
    }
    if (graph_.ltrs().empty()) {
      return failed(PlanStatus::kNoMap,
                    "There is no map yet: no local triangular region has been received.");
    }
    if (std::optional<Plan> refused = place("start", request_.start, PlanStatus::kStartOutsideMap,
                                            PlanStatus::kStartOccupied, start_)) {
      return refused;
    }
    return place("goal", request_.goal, PlanStatus::kGoalOutsideMap, PlanStatus::kGoalOccupied,
                 goal_);
  }

  bool isInformed(const Eigen::Vector2d& point) const {
    return !request_.is_informed || request_.is_informed(point);
  }

  GraphPlace locate(const Eigen::Vector2d& point) const {
    GraphPlace place;
    place.ltr = graph_.locate(point);
    if (place.ltr != kNone) place.local = graph_.ltr(place.ltr).triangle.toLocal(point);
    return place;
  }

  bool isFree(const GraphPlace& place) const {
    if (place.ltr == kNone) return false;
    const std::shared_ptr<const CellCosts>& costs = graph_.ltr(place.ltr).costs;
    return costs && costs->isPassable(costs->grid().index(place.local));
  }

  /// The nearest free place within the tolerance, found along spokes.
  std::optional<GraphPlace> nearestFree(const Eigen::Vector2d& point) const {
    for (double away = 0.0; away <= request_.tolerance_m; away += kSpokeStep_m) {
      for (int i = 0; i < (away > 0.0 ? kSpokes : 1); ++i) {
        const double angle = 2.0 * M_PI * i / kSpokes;
        const Eigen::Vector2d tried =
            point + away * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        const GraphPlace place = locate(tried);
        if (isFree(place) && isInformed(tried)) return place;
      }
    }
    return std::nullopt;
  }

  std::optional<Plan> place(const std::string& what, const Eigen::Vector2d& point,
                            PlanStatus outside, PlanStatus occupied, GraphPlace& found) const {
    const std::string where = "The " + what + " " + placeText(point);
    if (std::optional<GraphPlace> free = nearestFree(point)) {
      found = *free;
      return std::nullopt;
    }
    const GraphPlace exact = locate(point);
    if (exact.ltr == kNone) {
      return failed(outside, where +
                                 " lies outside of every local triangular region; drive there "
                                 "first, or ask for a place inside the map.");
    }
    if (!graph_.ltr(exact.ltr).costs) {
      return failed(outside, where + " lies in a region whose cells have not been received yet.");
    }
    if (isFree(exact)) {
      return failed(
          PlanStatus::kBelowInformation,
          where + " lies where the vehicle would know its pose less well than asked for.");
    }
    return failed(occupied, where +
                                " is occupied, or too near to something that is for the vehicle's "
                                "width; a larger tolerance lets it be moved.");
  }

  Plan stopped(PlanStatus status) const {
    if (status == PlanStatus::kCancelled) return failed(status, "The request was cancelled.");
    return failed(status, "No path was found within the time that was given.");
  }

  /// Tells whether there would be a way if no information were asked for.
  Plan noWay(DoorSearch& search) const {
    const std::string between =
        "from " + placeText(request_.start) + " to " + placeText(request_.goal);
    if (request_.is_informed) {
      DoorRoute route;
      if (search.find(graph_, start_, goal_, {}, route) == SearchOutcome::kFound) {
        return failed(PlanStatus::kBelowInformation,
                      "Every way " + between +
                          " leads through places where the vehicle would know its pose less well "
                          "than asked for; ask for less information.");
      }
    }
    return failed(PlanStatus::kNoPath,
                  "No way leads " + between +
                      " through doors that are wide enough: they lie in parts of the map that are "
                      "not connected for this vehicle.");
  }

  Plan describe(const DoorRoute& route) const {
    std::vector<PathPoint> path;
    for (const Waypoint& waypoint : route.waypoints) {
      path.push_back({graph_.ltr(waypoint.place.ltr).triangle.toGlobal(waypoint.place.local),
                      waypoint.place.ltr});
    }
    Plan plan;
    plan.status = PlanStatus::kOk;
    plan.expanded_portals = route.expanded;
    plan.cost_with_uncertainty = PathShortening(graph_, request_.is_informed).shorten(path);
    if (plan.cost_with_uncertainty == kNoPassing) {
      return failed(request_.is_informed ? PlanStatus::kBelowInformation : PlanStatus::kNoPath,
                    "The way along doors that was found is not free between them; ask again when "
                    "the map has changed.");
    }
    std::uint64_t last_door = 0;
    for (const int portal : route.portals) {
      const std::uint64_t door = graph_.doorOf(portal);
      if (door != last_door) plan.doors.push_back(door);
      last_door = door;
    }
    for (std::size_t i = 0; i < path.size(); ++i) {
      addPoint(path[i], plan);
      if (i == 0) continue;
      plan.cost +=
          graph_.integrateFromAny(path[i - 1].ltr, path[i - 1].position, path[i].position, false);
      plan.length_m += (path[i].position - path[i - 1].position).norm();
    }
    for (const Waypoint& waypoint : route.waypoints) {
      plan.worst_shape_factor =
          std::max(plan.worst_shape_factor, graph_.ltr(waypoint.place.ltr).factor);
    }
    std::ostringstream text;
    text.precision(1);
    text << std::fixed << "A path of " << plan.length_m << " m through " << plan.doors.size()
         << " doors.";
    plan.sentence = text.str();
    return plan;
  }

  void addPoint(const PathPoint& point, Plan& plan) const {
    const GraphLtr& ltr = graph_.ltr(point.ltr);
    plan.path.push_back(point.position);
    plan.points.push_back({ltr.view.id, ltr.view.landmark_ids,
                           Triangle::weights(ltr.triangle.toLocal(point.position))});
  }

  const DoorGraph& graph_;
  const PlanRequest& request_;
  GraphPlace start_, goal_;
};

}  // namespace

struct DoorPlanner::Searches {
  std::mutex mutex;
  std::vector<std::unique_ptr<DoorSearch>> idle;

  std::unique_ptr<DoorSearch> take() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (idle.empty()) return std::make_unique<DoorSearch>();
    std::unique_ptr<DoorSearch> search = std::move(idle.back());
    idle.pop_back();
    return search;
  }
  void giveBack(std::unique_ptr<DoorSearch> search) {
    const std::lock_guard<std::mutex> lock(mutex);
    idle.push_back(std::move(search));
  }
};

DoorPlanner::DoorPlanner(const DoorPlannerConfig& config)
    : config_(config),
      map_(config),
      graph_(std::make_shared<DoorGraph>()),
      searches_(std::make_unique<Searches>()) {}

DoorPlanner::~DoorPlanner() = default;

std::vector<int> DoorPlanner::setLtrs(const std::vector<LtrView>& ltrs) {
  return map_.setLtrs(ltrs);
}

bool DoorPlanner::setContent(int ltr, const LtrContent& content) {
  return map_.setContent(ltr, content);
}

std::size_t DoorPlanner::prepare(const Eigen::Vector2d& place, std::size_t max_matrices) {
  const std::size_t left = map_.prepare(place, max_matrices);
  std::shared_ptr<const DoorGraph> made = map_.makeGraph();
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  graph_ = std::move(made);
  return left;
}

std::shared_ptr<const DoorGraph> DoorPlanner::graph() const {
  const std::lock_guard<std::mutex> lock(graph_mutex_);
  return graph_;
}

Plan DoorPlanner::plan(const PlanRequest& request) const {
  const std::shared_ptr<const DoorGraph> now = graph();
  std::unique_ptr<DoorSearch> search = searches_->take();
  Plan plan = Query(*now, request).run(*search);
  searches_->giveBack(std::move(search));
  return plan;
}

std::optional<std::size_t> DoorPlanner::findBlocked(
    const std::vector<Eigen::Vector2d>& path) const {
  const std::shared_ptr<const DoorGraph> now = graph();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int ltr = now->locate(path[i - 1]);
    if (ltr == kNone || now->integrateFromAny(ltr, path[i - 1], path[i]) == kNoPassing) return i;
  }
  return std::nullopt;
}

}  // namespace hymm::core
