#include "door_planner/door_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
/// Ways are some percent dearer than the bound: some hundred buckets.
constexpr float kBucketsPerLowest = 8192.0F;
/// Portals of a side are taken up together if their totals differ by no more than this share.
constexpr float kTogether = 0.001F;
constexpr std::size_t kExpansionsBetweenStops = 1024;

}  // namespace

void DoorSearch::begin(const DoorGraph& graph, const GraphPlace& start, const GraphPlace& goal) {
  graph_ = &graph;
  for (std::vector<Entry>& bucket : buckets_) bucket.clear();
  first_bucket_ = 0;
  if (labels_.size() < std::size_t(graph.portalCount()) || states_.size() < graph.sides().size() ||
      query_ == std::numeric_limits<std::uint32_t>::max()) {
    labels_.resize(std::size_t(graph.portalCount()));
    states_.assign(graph.sides().size(), SideState());
    query_ = 0;
  }
  ++query_;
  const auto placeOf = [&](const GraphPlace& place) {
    return Eigen::Vector2f(
        (graph.ltr(place.ltr).triangle.toGlobal(place.local) - graph.origin()).cast<float>());
  };
  goal_ = placeOf(goal);
  // Rounded down, so that the bound stays one.
  least_ = static_cast<float>(graph.leastPerMetre() * (1.0 - 1e-6));
  lowest_ = least_ * (placeOf(start) - goal_).norm();
  buckets_per_cost_ = kBucketsPerLowest / std::max(lowest_, 1.0F);
  together_ = kTogether * lowest_;
  limit_ = kInfinite;
  last_ = kStart;
}

void DoorSearch::open(int number) {
  states_[std::size_t(number)] = {kInfinite, query_};
  const SearchSide& side = graph_->searchSide(number);
  for (int portal = side.first_portal; portal < side.first_portal + side.portals; ++portal) {
    const float bound = least_ * (graph_->searchPlaces()[portal] - goal_).norm();
    // Nothing is cheaper than minus infinity: what is not admitted stays out.
    const bool is_open = !options_->admits || options_->admits(graph_->placeOf(portal));
    labels_[std::size_t(portal)] = {is_open ? kInfinite : -kInfinite, bound,
                                    is_open ? kInfinite : -kInfinite, 2 * kStart};
  }
}

void DoorSearch::enqueue(int side, float total) {
  SideState& state = states_[std::size_t(side)];
  if (!(total < state.queued) || total >= limit_) return;
  state.queued = total;
  const float over = std::max(0.0F, (total - lowest_) * buckets_per_cost_);
  const std::size_t bucket = std::max(first_bucket_, std::size_t(over));
  if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
  buckets_[bucket].push_back({total, side});
}

void DoorSearch::offerStart(const GraphPlace& start, const PlaceLink& from) {
  const GraphLtr& ltr = graph_->ltr(start.ltr);
  for (std::size_t i = 0; i < from.ways.size(); ++i) {
    if (!from.ways[i].exists()) continue;
    const int portal = graph_->portalAt(start.ltr, static_cast<int>(i));
    const int side = graph_->sideOf(portal);
    if (states_[std::size_t(side)].query != query_) open(side);
    Label& label = labels_[std::size_t(portal)];
    const auto cost = static_cast<float>(ltr.factor * from.ways[i].cost);
    if (!(cost < label.cost)) continue;
    label.cost = cost;
    label.parent = 2 * kStart + (graph_->searchSide(side).ltrs[0] == start.ltr ? 0 : 1);
    enqueue(side, label.total());
  }
}

/// The next side to take up, unless it leads to nothing cheaper than what is known.
bool DoorSearch::next(Entry& entry) {
  for (; first_bucket_ < buckets_.size(); ++first_bucket_) {
    if (lowest_ + static_cast<float>(first_bucket_) / buckets_per_cost_ >= limit_) return false;
    std::vector<Entry>& bucket = buckets_[first_bucket_];
    while (!bucket.empty()) {
      entry = bucket.back();
      bucket.pop_back();
      SideState& state = states_[std::size_t(entry.side)];
      if (entry.total != state.queued) continue;
      state.queued = kInfinite;
      if (entry.total < limit_) return true;
    }
  }
  return false;
}

// The way to a portal came through one of its LTRs; on through the same it would be no cheaper than
// straight there, because cost matrices obey the triangle inequality. So it goes on through the
// other.
void DoorSearch::expand(int number, int portal) {
  const SearchSide& side = graph_->searchSide(number);
  const Label& label = labels_[std::size_t(portal)];
  const std::size_t end = 1 - label.end();
  const int through = side.ltrs[end];
  const SearchLtr& ltr = graph_->searchLtr(through);
  if (ltr.costs == nullptr) return;
  const int i = portal - side.first_portal;
  const float reached = label.cost + graph_->crossing(side, i, end);
  const float* row = ltr.costs + std::ptrdiff_t{side.index[end] + i} * ltr.size;
  for (std::size_t k = 0; k < 3; ++k) {
    if (ltr.sides[k] == kNone) continue;
    const SearchSide& to = graph_->searchSide(ltr.sides[k]);
    if (states_[std::size_t(ltr.sides[k])].query != query_) open(ltr.sides[k]);
    const float* costs = row + ltr.first_portal[k];
    Label* labels = labels_.data() + to.first_portal;
    float total = kInfinite;
    for (int j = 0; j < to.portals; ++j) {
      const float cost = reached + ltr.factor * costs[j];
      if (!(cost < labels[j].cost)) continue;
      if (options_->admits &&
          !admitsAll(*graph_, through, graph_->wayBetween(through, portal, to.first_portal + j),
                     options_->admits)) {
        continue;
      }
      labels[j].cost = cost;
      labels[j].parent = 2 * portal + (to.ltrs[0] == through ? 0 : 1);
      total = std::min(total, labels[j].total());
    }
    enqueue(ltr.sides[k], total);
  }
}

void DoorSearch::takeUp(const Entry& entry, const GraphPlace& goal, const PlaceLink& to,
                        DoorRoute& route) {
  const SearchSide& side = graph_->searchSide(entry.side);
  const bool is_last = side.ltrs[0] == goal.ltr || side.ltrs[1] == goal.ltr;
  float rest = kInfinite;
  for (int i = 0; i < side.portals; ++i) {
    const int portal = side.first_portal + i;
    Label& label = labels_[std::size_t(portal)];
    if (!label.isPending()) continue;
    if (label.total() > entry.total + together_) {
      rest = std::min(rest, label.total());
      continue;
    }
    label.expanded = label.cost;
    ++route.expanded;
    if (is_last) {
      const std::size_t end = side.ltrs[0] == goal.ltr ? 0 : 1;
      const float entered = label.end() == end ? 0.0F : graph_->crossing(side, i, end);
      const LocalPath& way = to.ways[std::size_t(side.index[end] + i)];
      const auto total =
          label.cost + entered + static_cast<float>(graph_->ltr(goal.ltr).factor * way.cost);
      if (total < limit_) {
        limit_ = total;
        last_ = portal;
      }
    }
    expand(entry.side, portal);
  }
  enqueue(entry.side, rest);
}

SearchOutcome DoorSearch::find(const DoorGraph& graph, const GraphPlace& start,
                               const GraphPlace& goal, const Options& options, DoorRoute& route) {
  options_ = &options;
  route = {};
  begin(graph, start, goal);
  const PlaceLink from(graph, start, LocalSearch::Direction::kFrom, options.admits,
                       start.ltr == goal.ltr ? &goal : nullptr);
  const PlaceLink to(graph, goal, LocalSearch::Direction::kTo, options.admits);
  if (from.direct.exists()) {
    limit_ = static_cast<float>(graph.ltr(start.ltr).factor * from.direct.cost);
  }
  offerStart(start, from);
  Entry entry{};
  std::size_t asked = 0;
  while (next(entry)) {
    if (options.stop && route.expanded >= asked + kExpansionsBetweenStops) {
      asked = route.expanded;
      if (options.stop()) return SearchOutcome::kStopped;
    }
    takeUp(entry, goal, to, route);
  }
  if (limit_ == kInfinite) return SearchOutcome::kNoWay;
  route.cost = static_cast<double>(limit_);
  trace(start, goal, from, to, route);
  return SearchOutcome::kFound;
}

void DoorSearch::trace(const GraphPlace& start, const GraphPlace& goal, const PlaceLink& from,
                       const PlaceLink& to, DoorRoute& route) const {
  for (int portal = last_; portal != kStart; portal = labels_[std::size_t(portal)].from()) {
    route.portals.push_back(portal);
  }
  std::reverse(route.portals.begin(), route.portals.end());
  const auto addPath = [&route](int ltr, const std::vector<Triangle::Local>& points) {
    // The first of them is there already.
    for (std::size_t i = 1; i < points.size(); ++i) route.waypoints.push_back({{ltr, points[i]}});
  };
  route.waypoints.push_back({start});
  if (route.portals.empty()) {
    addPath(start.ltr, from.direct.points);
    return;
  }
  for (std::size_t i = 0; i < route.portals.size(); ++i) {
    const int portal = route.portals[i];
    const SearchSide& side = graph_->searchSide(graph_->sideOf(portal));
    const int ltr = side.ltrs[labels_[std::size_t(portal)].end()];
    if (i == 0) {
      addPath(ltr, from.ways[std::size_t(graph_->portalIn(ltr, portal))].points);
    } else {
      addPath(ltr, graph_->wayBetween(ltr, route.portals[i - 1], portal));
    }
    route.waypoints.back().portal = portal;
  }
  addPath(goal.ltr, to.ways[std::size_t(graph_->portalIn(goal.ltr, last_))].points);
}

}  // namespace hymm::core
