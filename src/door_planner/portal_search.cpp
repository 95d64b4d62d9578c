#include "door_planner/portal_search.h"

#include <algorithm>
#include <utility>

namespace hymm::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
/// Ways are some percent dearer than the bound: some hundred buckets.
constexpr float kBucketsPerLowest = 8192.0F;
/// But not finer than this, in metres over the cheapest ground.
constexpr float kFinest_m = 0.1F;
/// Portals of a side are taken up together if their totals differ by no more than this share.
constexpr float kTogether = 0.001F;
/// And without a goal, in metres over the cheapest ground: what a bucket holds, too.
constexpr float kTogether_m = 2.0F;
constexpr std::size_t kExpansionsBetweenStops = 1024;

}  // namespace

void PortalSearch::begin(const Scope& scope, const Eigen::Vector2d* from,
                         const Eigen::Vector2d* goal) {
  scope_ = scope;
  graph_ = scope.graph;
  targets_.clear();
  if (labels_.size() < std::size_t(graph_->portalCount()) ||
      states_.size() < graph_->sides().size() ||
      search_ == std::numeric_limits<std::uint32_t>::max()) {
    labels_.resize(std::size_t(graph_->portalCount()));
    states_.assign(graph_->sides().size(), SideState());
    reached_searches_.clear();
    search_ = 0;
  }
  ++search_;
  expanded_ = 0;
  limit_ = kInfinite;
  last_ = kNone;
  // Rounded down, so that the bound stays one.
  least_ = static_cast<float>(graph_->leastPerMetre() * (1.0 - 1e-6));
  has_goal_ = goal != nullptr;
  if (has_goal_) {
    goal_ = (*goal - graph_->origin()).cast<float>();
    const float lowest = least_ * static_cast<float>((*from - *goal).norm());
    waiting_.begin(lowest, std::max(lowest / kBucketsPerLowest, kFinest_m * least_));
    together_ = kTogether * lowest;
  } else {
    together_ = kTogether_m * least_;
    waiting_.begin(0.0F, together_);
  }
}

void PortalSearch::open(int number) {
  states_[std::size_t(number)] = {kInfinite, search_};
  const SearchSide& side = graph_->searchSide(number);
  for (int portal = side.first_portal; portal < side.first_portal + side.portals; ++portal) {
    const float bound = has_goal_ ? least_ * (graph_->searchPlaces()[portal] - goal_).norm() : 0.0F;
    // Nothing is cheaper than minus infinity: what is not admitted stays out.
    const bool is_open = !scope_.admits || scope_.admits(graph_->placeOf(portal));
    labels_[std::size_t(portal)] = {is_open ? kInfinite : -kInfinite, bound,
                                    is_open ? kInfinite : -kInfinite, 2 * kStart};
  }
}

void PortalSearch::enqueue(int side, float total) {
  SideState& state = states_[std::size_t(side)];
  if (!(total < state.queued) || total >= limit_) return;
  state.queued = total;
  waiting_.push(total, side);
}

void PortalSearch::offer(int portal, int ltr, float cost) {
  const int side = graph_->sideOf(portal);
  if (states_[std::size_t(side)].search != search_) open(side);
  Label& label = labels_[std::size_t(portal)];
  if (!(cost < label.cost)) return;
  label.cost = cost;
  label.parent = 2 * kStart + (graph_->searchSide(side).ltrs[0] == ltr ? 0 : 1);
  enqueue(side, label.total());
}

/// The next side to take up, unless it leads to nothing cheaper than what is known.
bool PortalSearch::next(Entry& entry) {
  while (waiting_.pop(entry, limit_)) {
    SideState& state = states_[std::size_t(entry.value)];
    if (entry.key != state.queued) continue;
    state.queued = kInfinite;
    if (entry.key < limit_) return true;
  }
  return false;
}

void PortalSearch::relax(int number, std::size_t end, const Row& row) {
  if (states_[std::size_t(number)].search != search_) open(number);
  const SearchSide& side = graph_->searchSide(number);
  Label* labels = labels_.data() + side.first_portal;
  float total = kInfinite;
  for (int j = 0; j < side.portals; ++j) {
    const float cost = row.reached + row.factor * row.costs[j];
    if (!(cost < labels[j].cost)) continue;
    if (scope_.admits) {
      const int through = side.ltrs[end];
      const auto way = graph_->wayBetween(through, row.from, side.first_portal + j);
      if (!admitsAll(*graph_, through, way, scope_.admits)) continue;
    }
    labels[j].cost = cost;
    labels[j].parent = 2 * row.from + static_cast<int>(end);
    total = std::min(total, labels[j].total());
  }
  enqueue(number, total);
}

void PortalSearch::spread(int portal, int through, float reached) {
  const SearchLtr& ltr = graph_->searchLtr(through);
  if (ltr.costs == nullptr) return;
  const float* row = ltr.costs + std::ptrdiff_t{graph_->portalIn(through, portal)} * ltr.size;
  for (std::size_t k = 0; k < 3; ++k) {
    const int to = ltr.sides[k];
    if (to == kNone) continue;
    const std::size_t end = graph_->searchSide(to).ltrs[0] == through ? 0 : 1;
    relax(to, end, {portal, reached, row + ltr.first_portal[k], ltr.factor});
  }
}

/// Costs at which the portals on a district's border have been reached through it.
float* PortalSearch::reachedThrough(int number) {
  const DistrictLayout::District& district = scope_.districts->district(number);
  if (reached_.size() < std::size_t(scope_.districts->borderPortals())) {
    reached_.resize(std::size_t(scope_.districts->borderPortals()));
  }
  if (reached_searches_.size() < scope_.districts->count()) {
    reached_searches_.resize(scope_.districts->count(), 0);
  }
  float* reached = reached_.data() + district.first_portal;
  if (std::exchange(reached_searches_[std::size_t(number)], search_) != search_) {
    std::fill_n(reached, district.portals, kInfinite);
  }
  return reached;
}

// Most ways across a district are no cheaper than those that are known: what tells that lies side
// by side, in the order of a row.
void PortalSearch::spreadAcross(int portal, int side, std::size_t end, int district, float cost) {
  const int i = portal - graph_->searchSide(side).first_portal;
  const float* row =
      scope_.districts->matrix(district)->row(scope_.districts->rowOf(side, end) + i);
  float* reached = reachedThrough(district);
  for (const DistrictLayout::Border& border : scope_.districts->district(district).borders) {
    bool any = false;
    for (int j = border.first_portal; j < border.first_portal + border.portals; ++j) {
      const float through = cost + row[j];
      any = any || through < reached[j];
      reached[j] = std::min(reached[j], through);
    }
    if (any) relax(border.side, border.end, {portal, cost, row + border.first_portal, 1.0F});
  }
}

// The way to a portal came through one of its LTRs, or the district it lies in; on through the same
// it would be no cheaper than straight there, because cost matrices obey the triangle inequality.
// So it goes on through the other; through both where the way straight there may not be admitted.
void PortalSearch::expand(int number, int portal) {
  const SearchSide& side = graph_->searchSide(number);
  const Label& label = labels_[std::size_t(portal)];
  const std::size_t end = 1 - label.end();
  if (scope_.admits) spread(portal, side.ltrs[label.end()], label.cost);
  const int through = side.ltrs[end];
  const float reached = label.cost + graph_->crossing(side, portal - side.first_portal, end);
  if (scope_.districts != nullptr) {
    const int district = scope_.districts->districtOf(through);
    if (crossesAtOnce(district)) return spreadAcross(portal, number, end, district, reached);
    if (scope_.only != kNone && district != scope_.only) return;
  }
  spread(portal, through, reached);
}

void PortalSearch::reach(const Target& target, int portal) {
  const SearchSide& side = graph_->searchSide(target.side);
  const Label& label = labels_[std::size_t(portal)];
  const int i = portal - side.first_portal;
  const float entered = label.end() == target.end ? 0.0F : graph_->crossing(side, i, target.end);
  const float total = label.cost + entered + target.costs[std::size_t(i)];
  if (!(total < limit_)) return;
  limit_ = total;
  last_ = portal;
}

void PortalSearch::takeUp(const Entry& entry) {
  const SearchSide& side = graph_->searchSide(entry.value);
  const auto target = std::find_if(targets_.begin(), targets_.end(),
                                   [&](const Target& t) { return t.side == entry.value; });
  float rest = kInfinite;
  for (int portal = side.first_portal; portal < side.first_portal + side.portals; ++portal) {
    Label& label = labels_[std::size_t(portal)];
    if (!label.isPending()) continue;
    if (label.total() > entry.key + together_) {
      rest = std::min(rest, label.total());
      continue;
    }
    label.expanded = label.cost;
    ++expanded_;
    if (target != targets_.end()) reach(*target, portal);
    expand(entry.value, portal);
  }
  enqueue(entry.value, rest);
}

bool PortalSearch::run() {
  Entry entry{};
  std::size_t asked = 0;
  while (next(entry)) {
    if (scope_.stop && expanded_ >= asked + kExpansionsBetweenStops) {
      asked = expanded_;
      if (scope_.stop()) return false;
    }
    takeUp(entry);
  }
  return true;
}

float PortalSearch::costTo(int portal) const {
  const bool is_known = states_[std::size_t(graph_->sideOf(portal))].search == search_;
  return is_known ? labels_[std::size_t(portal)].cost : kInfinite;
}

std::vector<PortalSearch::Step> PortalSearch::way(int from) const {
  std::vector<Step> steps;
  for (int portal = last_; portal != kNone && portal != from;) {
    const Label& label = labels_[std::size_t(portal)];
    steps.push_back({portal, graph_->searchSide(graph_->sideOf(portal)).ltrs[label.end()]});
    portal = label.from() == kStart ? kNone : label.from();
  }
  std::reverse(steps.begin(), steps.end());
  return steps;
}

}  // namespace hymm::core
