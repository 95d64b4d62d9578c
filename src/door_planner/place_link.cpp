#include "door_planner/place_link.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hymm::core {
namespace {

constexpr double kAdmittedEvery_m = 0.25;

}  // namespace

bool admitsAll(const DoorGraph& graph, int ltr, const std::vector<Triangle::Local>& points,
               const Admits& admits) {
  if (!admits) return true;
  const Triangle& triangle = graph.ltr(ltr).triangle;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d from = triangle.toGlobal(points[i - 1]);
    const Eigen::Vector2d along = triangle.toGlobal(points[i]) - from;
    const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / kAdmittedEvery_m)));
    for (int k = 0; k <= parts; ++k) {
      if (!admits(from + along * k / parts)) return false;
    }
  }
  return true;
}

PlaceLink::PlaceLink(const DoorGraph& graph, const GraphPlace& place,
                     LocalSearch::Direction direction, const Admits& admits,
                     const GraphPlace* other) {
  const GraphLtr& ltr = graph.ltr(place.ltr);
  std::vector<Triangle::Local> targets = graph.portalsOf(place.ltr);
  if (other != nullptr) targets.push_back(other->local);
  LocalSearch search(ltr.triangle, *ltr.costs, graph.maxMetricError());
  ways = search.find(place.local, targets, direction);
  if (other != nullptr) {
    direct = std::move(ways.back());
    ways.pop_back();
    if (direct.exists() && !admitsAll(graph, place.ltr, direct.points, admits)) direct = {};
  }
  // What is not admitted must not take the place of what is.
  if (!admits) close(graph, place.ltr, direction);
  for (LocalPath& way : ways) {
    if (way.exists() && !admitsAll(graph, place.ltr, way.points, admits)) way = {};
  }
}

// As with cost matrices: what is cheaper through another portal goes that way.
void PlaceLink::close(const DoorGraph& graph, int ltr_number, LocalSearch::Direction direction) {
  const GraphLtr& ltr = graph.ltr(ltr_number);
  if (!ltr.matrix) return;
  const bool is_from = direction == LocalSearch::Direction::kFrom;
  for (int via = 0; via < ltr.matrix->size(); ++via) {
    for (int end = 0; end < ltr.matrix->size(); ++end) {
      const auto between =
          static_cast<double>(is_from ? ltr.matrix->cost(via, end) : ltr.matrix->cost(end, via));
      const double around = ways[std::size_t(via)].cost + between;
      LocalPath& path = ways[std::size_t(end)];
      if (via == end || !(around < path.cost * (1.0 - 1e-6))) continue;
      const int first = graph.portalAt(ltr_number, is_from ? via : end);
      const int second = graph.portalAt(ltr_number, is_from ? end : via);
      std::vector<Triangle::Local> way = graph.wayBetween(ltr_number, first, second);
      const std::vector<Triangle::Local>& rest = ways[std::size_t(via)].points;
      if (is_from) {
        way.insert(way.begin(), rest.begin(), rest.end() - 1);
      } else {
        way.insert(way.end(), rest.begin() + 1, rest.end());
      }
      path = {around, std::move(way)};
    }
  }
}

}  // namespace hymm::core
