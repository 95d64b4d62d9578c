#include "door_planner/door_search.h"

#include <limits>
#include <utility>

namespace hymm::core {
namespace {

/// Share by which sums of the same costs may differ.
constexpr float kRounding = 1e-4F;
constexpr float kInfinite = std::numeric_limits<float>::infinity();

void offerStart(const DoorGraph& graph, const GraphPlace& start, const PlaceLink& from,
                PortalSearch& search) {
  for (std::size_t i = 0; i < from.ways.size(); ++i) {
    if (!from.ways[i].exists()) continue;
    search.offer(graph.portalAt(start.ltr, static_cast<int>(i)), start.ltr,
                 static_cast<float>(graph.ltr(start.ltr).factor * from.ways[i].cost));
  }
}

/// Sides of the goal's LTR, with what it costs from their portals on.
std::vector<PortalSearch::Target> targetsAround(const DoorGraph& graph, const GraphPlace& goal,
                                                const PlaceLink& to) {
  const GraphLtr& ltr = graph.ltr(goal.ltr);
  std::vector<PortalSearch::Target> targets;
  for (std::size_t k = 0; k < 3; ++k) {
    if (ltr.sides[k] == kNone) continue;
    PortalSearch::Target target;
    target.side = ltr.sides[k];
    target.end = graph.side(target.side).ltrs[0] == goal.ltr ? 0 : 1;
    for (int i = ltr.first_portal[k]; i < ltr.first_portal[k + 1]; ++i) {
      target.costs.push_back(static_cast<float>(ltr.factor * to.ways[std::size_t(i)].cost));
    }
    targets.push_back(std::move(target));
  }
  return targets;
}

/// Joins the ways between portals; those of start and goal are known already.
void joinWays(const DoorGraph& graph, const std::vector<PortalSearch::Step>& steps,
              const GraphPlace& start, const GraphPlace& goal, const PlaceLink& from,
              const PlaceLink& to, DoorRoute& route) {
  const auto addPath = [&route](int ltr, const std::vector<Triangle::Local>& points) {
    // The first of them is there already.
    for (std::size_t i = 1; i < points.size(); ++i) route.waypoints.push_back({{ltr, points[i]}});
  };
  route.waypoints.push_back({start});
  if (steps.empty()) return addPath(start.ltr, from.direct.points);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto [portal, ltr] = steps[i];
    if (i == 0) {
      addPath(ltr, from.ways[std::size_t(graph.portalIn(ltr, portal))].points);
    } else {
      addPath(ltr, graph.wayBetween(ltr, steps[i - 1].portal, portal));
    }
    route.waypoints.back().portal = portal;
    route.portals.push_back(portal);
  }
  addPath(goal.ltr, to.ways[std::size_t(graph.portalIn(goal.ltr, steps.back().portal))].points);
}

}  // namespace

PortalSearch::Scope DoorSearch::scopeOf(const DoorGraph& graph, const GraphPlace& start,
                                        const GraphPlace& goal, const Options& options) const {
  PortalSearch::Scope scope;
  scope.graph = &graph;
  scope.admits = options.admits;
  scope.stop = options.stop;
  if (options.districts == nullptr || options.admits) return scope;
  scope.districts = options.districts;
  scope.taken_apart = {scope.districts->districtOf(start.ltr),
                       scope.districts->districtOf(goal.ltr)};
  return scope;
}

SearchOutcome DoorSearch::find(const DoorGraph& graph, const GraphPlace& start,
                               const GraphPlace& goal, const Options& options, DoorRoute& route) {
  route = {};
  const PlaceLink from(graph, start, LocalSearch::Direction::kFrom, options.admits,
                       start.ltr == goal.ltr ? &goal : nullptr);
  const PlaceLink to(graph, goal, LocalSearch::Direction::kTo, options.admits);
  const PortalSearch::Scope scope = scopeOf(graph, start, goal, options);
  const Eigen::Vector2d start_place = graph.ltr(start.ltr).triangle.toGlobal(start.local);
  const Eigen::Vector2d goal_place = graph.ltr(goal.ltr).triangle.toGlobal(goal.local);
  portals_.begin(scope, &start_place, &goal_place);
  portals_.setTargets(targetsAround(graph, goal, to));
  if (from.direct.exists()) {
    portals_.limit(static_cast<float>(graph.ltr(start.ltr).factor * from.direct.cost));
  }
  offerStart(graph, start, from, portals_);
  const bool ended = portals_.run();
  route.expanded = portals_.expanded();
  if (!ended) return SearchOutcome::kStopped;
  if (portals_.cost() == kInfinite) return SearchOutcome::kNoWay;
  route.cost = static_cast<double>(portals_.cost());
  joinWays(graph, stepsAlong(scope, route), start, goal, from, to, route);
  return SearchOutcome::kFound;
}

/// The steps of the way that was found, LTR by LTR.
std::vector<PortalSearch::Step> DoorSearch::stepsAlong(const PortalSearch::Scope& scope,
                                                       DoorRoute& route) {
  const std::vector<Step> coarse = portals_.way();
  std::vector<bool> at_once(coarse.size(), false);
  for (std::size_t i = 1; i < coarse.size() && scope.districts != nullptr; ++i) {
    at_once[i] = portals_.crossesAtOnce(scope.districts->districtOf(coarse[i].ltr));
  }
  std::vector<Step> steps;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    if (!at_once[i]) {
      steps.push_back(coarse[i]);
      continue;
    }
    const int district = scope.districts->districtOf(coarse[i].ltr);
    const std::vector<Step> inside =
        stepsInside(scope, district, coarse[i - 1].portal, coarse[i].portal);
    steps.insert(steps.end(), inside.begin(), inside.end());
    route.expanded += portals_.expanded();
  }
  return steps;
}

/// The cheapest way across a district, between two portals on its border.
std::vector<PortalSearch::Step> DoorSearch::stepsInside(const PortalSearch::Scope& scope,
                                                        int district, int from, int to) {
  const DoorGraph& graph = *scope.graph;
  const auto endIn = [&](int portal) {
    const int first = graph.side(graph.sideOf(portal)).ltrs[0];
    return scope.districts->districtOf(first) == district ? std::size_t{0} : std::size_t{1};
  };
  PortalSearch::Scope inside = scope;
  inside.only = district;
  portals_.begin(inside, &graph.placeOf(from), &graph.placeOf(to));
  const GraphSide& last = graph.side(graph.sideOf(to));
  PortalSearch::Target target{graph.sideOf(to), endIn(to), {}};
  target.costs.assign(std::size_t(last.portals), kInfinite);
  target.costs[std::size_t(to - last.first_portal)] = 0.0F;
  portals_.setTargets({target});
  const Districts& districts = *scope.districts;
  const auto rowOf = [&](int portal) {
    const int side = graph.sideOf(portal);
    return districts.rowOf(side, endIn(portal)) + portal - graph.side(side).first_portal;
  };
  portals_.limit(districts.matrix(district)->row(rowOf(from))[rowOf(to)] * (1.0F + kRounding));
  portals_.offerFrom(from, graph.side(graph.sideOf(from)).ltrs[endIn(from)]);
  portals_.run();
  return portals_.way(from);
}

}  // namespace hymm::core
