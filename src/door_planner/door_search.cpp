#include "door_planner/door_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kBucketsPerLowest = 8192.0F;
constexpr double kAdmittedEvery_m = 0.25;
constexpr std::size_t kExpansionsBetweenStops = 1024;

std::vector<Triangle::Local> portalsOf(const DoorGraph& graph, int ltr_number) {
  std::vector<Triangle::Local> portals;
  for (const int number : graph.ltr(ltr_number).sides) {
    if (number == kNone) continue;
    const GraphSide& side = graph.side(number);
    for (int i = 0; i < side.portals; ++i) {
      portals.push_back(graph.localOf(ltr_number, side.first_portal + i));
    }
  }
  return portals;
}

/// The portal of the graph that is the `index`-th of an LTR.
int portalAt(const DoorGraph& graph, int ltr_number, int index) {
  const GraphLtr& ltr = graph.ltr(ltr_number);
  const std::size_t k = index < ltr.first_portal[1] ? 0 : index < ltr.first_portal[2] ? 1 : 2;
  return graph.side(ltr.sides[k]).first_portal + index - ltr.first_portal[k];
}

}  // namespace

void DoorSearch::begin(const DoorGraph& graph) {
  graph_ = &graph;
  for (std::vector<Entry>& bucket : buckets_) bucket.clear();
  first_bucket_ = 0;
  if (labels_.size() < std::size_t(graph.portalCount()) ||
      query_ == std::numeric_limits<std::uint32_t>::max()) {
    labels_.assign(std::size_t(graph.portalCount()), Label());
    query_ = 0;
  }
  ++query_;
  // Rounded down, so that the bound stays one.
  least_ = static_cast<float>(graph.leastPerMetre() * (1.0 - 1e-6));
}

void DoorSearch::open(int portal) {
  Label& label = labels_[std::size_t(portal)];
  const float bound = least_ * (graph_->searchPortal(portal).place - goal_).norm();
  label = {kInfinite, bound, 2 * kStart, query_};
  // Nothing is cheaper than that: it stays out.
  if (options_->admits && !options_->admits(graph_->placeOf(portal))) label.cost = -kInfinite;
}

void DoorSearch::offer(int portal, float cost, int parent, int through) {
  Label& label = labels_[std::size_t(portal)];
  if (label.query != query_) open(portal);
  if (!(cost < label.cost)) return;
  label.cost = cost;
  label.parent = 2 * parent + (graph_->searchPortal(portal).ltrs[0] == through ? 0 : 1);
  const float over = std::max(0.0F, (cost + label.bound - lowest_) * buckets_per_cost_);
  const std::size_t bucket = std::max(first_bucket_, std::size_t(over));
  if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
  buckets_[bucket].push_back({cost, portal});
}

/// The next portal to take up, unless it leads to nothing cheaper than `limit`.
bool DoorSearch::next(float limit, Entry& entry) {
  for (; first_bucket_ < buckets_.size(); ++first_bucket_) {
    if (lowest_ + static_cast<float>(first_bucket_) / buckets_per_cost_ >= limit) return false;
    std::vector<Entry>& bucket = buckets_[first_bucket_];
    while (!bucket.empty()) {
      entry = bucket.back();
      bucket.pop_back();
      const Label& label = labels_[std::size_t(entry.portal)];
      if (entry.cost == label.cost && entry.cost + label.bound < limit) return true;
    }
  }
  return false;
}

bool DoorSearch::admits(int ltr_number, const std::vector<Triangle::Local>& points) const {
  if (!options_->admits) return true;
  const Triangle& triangle = graph_->ltr(ltr_number).triangle;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d from = triangle.toGlobal(points[i - 1]);
    const Eigen::Vector2d along = triangle.toGlobal(points[i]) - from;
    const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / kAdmittedEvery_m)));
    for (int k = 0; k <= parts; ++k) {
      if (!options_->admits(from + along * k / parts)) return false;
    }
  }
  return true;
}

bool DoorSearch::admitsWay(int ltr, int from, int to) const {
  return admits(ltr, wayBetween(ltr, from, to));
}

std::vector<Triangle::Local> DoorSearch::wayBetween(int ltr, int from, int to) const {
  std::vector<Triangle::Local> way =
      graph_->ltr(ltr).matrix->turns(graph_->portalIn(ltr, from), graph_->portalIn(ltr, to));
  way.insert(way.begin(), graph_->localOf(ltr, from));
  way.push_back(graph_->localOf(ltr, to));
  return way;
}

// As with cost matrices: what is cheaper through another portal goes that way.
void DoorSearch::close(int ltr_number, LocalSearch::Direction direction,
                       std::vector<LocalPath>& paths) const {
  const GraphLtr& ltr = graph_->ltr(ltr_number);
  if (!ltr.matrix) return;
  const bool is_from = direction == LocalSearch::Direction::kFrom;
  for (int via = 0; via < ltr.matrix->size(); ++via) {
    for (int end = 0; end < ltr.matrix->size(); ++end) {
      const auto between =
          static_cast<double>(is_from ? ltr.matrix->cost(via, end) : ltr.matrix->cost(end, via));
      const double around = paths[std::size_t(via)].cost + between;
      LocalPath& path = paths[std::size_t(end)];
      if (via == end || !(around < path.cost * (1.0 - 1e-6))) continue;
      const int first = portalAt(*graph_, ltr_number, is_from ? via : end);
      const int second = portalAt(*graph_, ltr_number, is_from ? end : via);
      std::vector<Triangle::Local> way = wayBetween(ltr_number, first, second);
      const std::vector<Triangle::Local>& rest = paths[std::size_t(via)].points;
      if (is_from) {
        way.insert(way.begin(), rest.begin(), rest.end() - 1);
      } else {
        way.insert(way.end(), rest.begin() + 1, rest.end());
      }
      path = {around, std::move(way)};
    }
  }
  for (LocalPath& path : paths) {
    if (path.exists() && !admits(ltr_number, path.points)) path = {};
  }
}

// The way to a portal came through one of its LTRs; on through the same it would be no cheaper than
// straight there, because cost matrices obey the triangle inequality. So it goes on through the
// other.
void DoorSearch::expand(int portal) {
  const Label& label = labels_[std::size_t(portal)];
  const float reached = label.cost;
  const SearchPortal& from = graph_->searchPortal(portal);
  const std::size_t end = label.end() == 0 ? 1 : 0;
  const int next = from.ltrs[end];
  const SearchLtr& ltr = graph_->searchLtr(next);
  if (ltr.costs == nullptr) return;
  const float* row = ltr.costs + std::ptrdiff_t{from.index[end]} * ltr.size;
  for (std::size_t k = 0; k < 3; ++k) {
    for (int i = ltr.first_portal[k]; i < ltr.first_portal[k + 1]; ++i) {
      const float cost = reached + ltr.factor * row[i];
      const int to = ltr.offsets[k] + i;
      const Label& known = labels_[std::size_t(to)];
      if (!(cost < (known.query == query_ ? known.cost : kInfinite))) continue;
      if (options_->admits && !admitsWay(next, portal, to)) continue;
      offer(to, cost, portal, next);
    }
  }
}

SearchOutcome DoorSearch::find(const DoorGraph& graph, const GraphPlace& start,
                               const GraphPlace& goal, const Options& options, DoorRoute& route) {
  begin(graph);
  options_ = &options;
  goal_ = (graph.ltr(goal.ltr).triangle.toGlobal(goal.local) - graph.origin()).cast<float>();
  const Eigen::Vector2d start_place = graph.ltr(start.ltr).triangle.toGlobal(start.local);
  lowest_ = least_ * ((start_place - graph.origin()).cast<float>() - goal_).norm();
  // Ways are some percent dearer than the bound: some hundred buckets.
  buckets_per_cost_ = kBucketsPerLowest / std::max(lowest_, 1.0F);
  const GraphLtr& first = graph.ltr(start.ltr);
  const GraphLtr& last = graph.ltr(goal.ltr);

  std::vector<Triangle::Local> targets = portalsOf(graph, start.ltr);
  if (start.ltr == goal.ltr) targets.push_back(goal.local);
  LocalSearch from(first.triangle, *first.costs, graph.maxMetricError());
  from_start_ = from.find(start.local, targets);
  direct_ = {};
  if (start.ltr == goal.ltr) {
    direct_ = std::move(from_start_.back());
    from_start_.pop_back();
    if (direct_.exists() && !admits(start.ltr, direct_.points)) direct_ = {};
  }
  close(start.ltr, LocalSearch::Direction::kFrom, from_start_);
  LocalSearch to(last.triangle, *last.costs, graph.maxMetricError());
  to_goal_ = to.find(goal.local, portalsOf(graph, goal.ltr), LocalSearch::Direction::kTo);
  close(goal.ltr, LocalSearch::Direction::kTo, to_goal_);

  for (std::size_t i = 0; i < from_start_.size(); ++i) {
    if (!from_start_[i].exists()) continue;
    offer(portalAt(graph, start.ltr, static_cast<int>(i)),
          static_cast<float>(first.factor * from_start_[i].cost), kStart, start.ltr);
  }
  double best = direct_.exists() ? first.factor * direct_.cost : kNoPassing;
  int best_last = kStart;
  route = {};
  Entry entry{};
  while (next(static_cast<float>(best), entry)) {
    const Label& label = labels_[std::size_t(entry.portal)];
    if (++route.expanded % kExpansionsBetweenStops == 0 && options.stop && options.stop()) {
      return SearchOutcome::kStopped;
    }
    const SearchPortal& portal = graph.searchPortal(entry.portal);
    if (portal.ltrs[0] == goal.ltr || portal.ltrs[1] == goal.ltr) {
      const LocalPath& end = to_goal_[std::size_t(graph.portalIn(goal.ltr, entry.portal))];
      const double total = static_cast<double>(label.cost) + last.factor * end.cost;
      if (total < best) {
        best = total;
        best_last = entry.portal;
      }
    }
    expand(entry.portal);
  }
  if (best == kNoPassing) return SearchOutcome::kNoWay;
  route.cost = best;
  trace(start, goal, best_last, route);
  return SearchOutcome::kFound;
}

void DoorSearch::trace(const GraphPlace& start, const GraphPlace& goal, int last,
                       DoorRoute& route) const {
  for (int portal = last; portal != kStart; portal = labels_[std::size_t(portal)].from()) {
    route.portals.push_back(portal);
  }
  std::reverse(route.portals.begin(), route.portals.end());
  const auto addPath = [&route](int ltr, const std::vector<Triangle::Local>& points) {
    // The first of them is there already.
    for (std::size_t i = 1; i < points.size(); ++i) route.waypoints.push_back({{ltr, points[i]}});
  };
  route.waypoints.push_back({start});
  if (route.portals.empty()) {
    addPath(start.ltr, direct_.points);
    return;
  }
  for (std::size_t i = 0; i < route.portals.size(); ++i) {
    const int portal = route.portals[i];
    const int ltr =
        graph_->searchPortal(portal).ltrs[std::size_t(labels_[std::size_t(portal)].end())];
    if (i == 0) {
      addPath(ltr, from_start_[std::size_t(graph_->portalIn(ltr, portal))].points);
    } else {
      addPath(ltr, wayBetween(ltr, route.portals[i - 1], portal));
    }
    route.waypoints.back().portal = portal;
  }
  addPath(goal.ltr, to_goal_[std::size_t(graph_->portalIn(goal.ltr, last))].points);
}

}  // namespace hymm::core
