#include "door_planner/door_graph.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

/// Weight of the vertex opposite to side k, which is 0 on the side: linear in local coordinates.
double weightOpposite(int side, const Triangle::Local& local) {
  if (side == 0) return local.y();
  if (side == 1) return 1.0 - local.x() - local.y();
  return local.x();
}

double rateOpposite(int side, const Triangle::Local& along) {
  if (side == 0) return along.y();
  if (side == 1) return -along.x() - along.y();
  return along.x();
}

/// The side across which a line leaves an LTR that it is in at share `at`, and the share where.
int exitOf(const Triangle::Local& from, const Triangle::Local& along, double at, double& leave) {
  int exit = kNone;
  leave = 1.0;
  for (int k = 0; k < 3; ++k) {
    const double rate = rateOpposite(k, along);
    if (rate >= 0.0 || weightOpposite(k, from) + rate >= -kBorderTolerance) continue;
    const double crossing = std::max(at, -weightOpposite(k, from) / rate);
    if (exit == kNone || crossing < leave) {
      exit = k;
      leave = crossing;
    }
  }
  return exit;
}

/// Of going from one LTR to the next, where a layer rises or falls.
double crossingCost(const GraphLtr& from, const GraphLtr& to, const Eigen::Vector2d& place) {
  if (!from.costs->isDirected() || !to.costs || !to.costs->isDirected()) return 0.0;
  const int before = from.costs->grid().index(from.triangle.toLocal(place));
  const int after = to.costs->grid().index(to.triangle.toLocal(place));
  return static_cast<double>(CellCosts::passing(*from.costs, before, *to.costs, after));
}

}  // namespace

DoorGraph::DoorGraph(std::vector<GraphLtr> ltrs, std::vector<GraphSide> sides,
                     double max_metric_error)
    : ltrs_(std::move(ltrs)), max_metric_error_(max_metric_error) {
  const auto frame = std::make_shared<Frame>();
  frame_ = frame;
  frame->sides = std::move(sides);
  numberPortals(*frame);
  for (const GraphLtr& ltr : ltrs_) {
    if (!ltr.costs) continue;
    least_ = std::min(least_, ltr.factor * ltr.costs->leastPerMetre() / ltr.stretch);
  }
  if (!ltrs_.empty()) {
    spanBuckets(*frame);
    fillBuckets(*frame);
  }
  prepareSearch(*frame);
}

std::shared_ptr<const DoorGraph> DoorGraph::with(const std::vector<GraphChange>& changes) const {
  const auto isDirected = [](const std::shared_ptr<const CellCosts>& costs) {
    return costs && costs->isDirected();
  };
  for (const GraphChange& change : changes) {
    if (isDirected(change.costs) || isDirected(ltr(change.ltr).costs)) return nullptr;
  }
  const auto made = std::make_shared<DoorGraph>(*this);
  for (const GraphChange& change : changes) {
    GraphLtr& ltr = made->ltrs_[std::size_t(change.ltr)];
    ltr.costs = change.costs;
    ltr.matrix = change.matrix;
    ltr.stretch = change.stretch;
    made->search_ltrs_[std::size_t(change.ltr)].costs = ltr.matrix ? ltr.matrix->row(0) : nullptr;
    // What was there before may have been the least: then this stays a bound, if not the best.
    if (!ltr.costs) continue;
    made->least_ = std::min(made->least_, ltr.factor * ltr.costs->leastPerMetre() / ltr.stretch);
  }
  return made;
}

void DoorGraph::prepareSearch(Frame& frame) {
  search_ltrs_.resize(ltrs_.size());
  frame.search_sides.resize(frame.sides.size());
  for (std::size_t i = 0; i < frame.sides.size(); ++i) {
    frame.search_sides[i].first_portal = frame.sides[i].first_portal;
    frame.search_sides[i].portals = frame.sides[i].portals;
    frame.search_sides[i].ltrs = frame.sides[i].ltrs;
  }
  for (std::size_t number = 0; number < ltrs_.size(); ++number) {
    const GraphLtr& from = ltrs_[number];
    SearchLtr& to = search_ltrs_[number];
    if (from.matrix) to.costs = from.matrix->row(0);
    to.factor = static_cast<float>(from.factor);
    to.size = from.first_portal[3];
    to.sides = from.sides;
    for (std::size_t k = 0; k < 3; ++k) {
      to.first_portal[k + 1] = static_cast<std::uint16_t>(from.first_portal[k + 1]);
      if (from.sides[k] == kNone) continue;
      SearchSide& side = frame.search_sides[std::size_t(from.sides[k])];
      side.index[side.ltrs[0] == static_cast<int>(number) ? 0 : 1] = to.first_portal[k];
    }
  }
  frame.search_places.reserve(frame.places.size());
  for (const Eigen::Vector2d& place : frame.places) {
    frame.search_places.emplace_back((place - frame.low).cast<float>());
  }
  for (SearchSide& side : frame.search_sides) addCrossings(frame, side);
}

void DoorGraph::addCrossings(Frame& frame, SearchSide& side) const {
  const CellCosts* costs[2];
  for (std::size_t end = 0; end < 2; ++end) {
    costs[end] = ltr(side.ltrs[end]).costs.get();
    if (costs[end] == nullptr || !costs[end]->isDirected()) return;
  }
  side.crossing = static_cast<int>(frame.crossings.size() / 2);
  for (int i = 0; i < side.portals; ++i) {
    int cells[2];
    for (std::size_t end = 0; end < 2; ++end) {
      cells[end] = costs[end]->grid().index(localOf(side.ltrs[end], side.first_portal + i));
    }
    for (const std::size_t end : {0U, 1U}) {
      frame.crossings.push_back(
          searchLtr(side.ltrs[end]).factor *
          CellCosts::passing(*costs[1 - end], cells[1 - end], *costs[end], cells[end]));
    }
  }
}

void DoorGraph::numberPortals(Frame& frame) {
  int count = 0;
  for (GraphSide& side : frame.sides) {
    side.first_portal = count;
    side.portals = side.doors ? static_cast<int>(side.doors->portals.size()) : 0;
    count += side.portals;
  }
  frame.places.resize(std::size_t(count));
  frame.side_of_portal.resize(std::size_t(count));
  for (GraphLtr& ltr : ltrs_) {
    for (int k = 0; k < 3; ++k) {
      const int number = ltr.sides[std::size_t(k)];
      const int portals = number == kNone ? 0 : side(number).portals;
      ltr.first_portal[std::size_t(k) + 1] = ltr.first_portal[std::size_t(k)] + portals;
      for (int i = 0; i < portals; ++i) {
        const std::size_t portal = std::size_t(side(number).first_portal + i);
        frame.side_of_portal[portal] = number;
        frame.places[portal] = ltr.triangle.toGlobal(
            placeOnSide(ltr.view, k, side(number).doors->portals[std::size_t(i)]));
      }
    }
  }
}

int DoorGraph::portalIn(int ltr_number, int portal) const {
  const GraphLtr& of = ltr(ltr_number);
  const int number = sideOf(portal);
  const int k = of.sides[0] == number ? 0 : of.sides[1] == number ? 1 : 2;
  return of.first_portal[std::size_t(k)] + portal - side(number).first_portal;
}

Triangle::Local DoorGraph::localOf(int ltr_number, int portal) const {
  const GraphLtr& of = ltr(ltr_number);
  const int number = sideOf(portal);
  const int k = of.sides[0] == number ? 0 : of.sides[1] == number ? 1 : 2;
  return placeOnSide(of.view, k,
                     side(number).doors->portals[std::size_t(portal - side(number).first_portal)]);
}

int DoorGraph::portalAt(int ltr_number, int index) const {
  const GraphLtr& of = ltr(ltr_number);
  const std::size_t k = index < of.first_portal[1] ? 0 : index < of.first_portal[2] ? 1 : 2;
  return side(of.sides[k]).first_portal + index - of.first_portal[k];
}

std::vector<Triangle::Local> DoorGraph::portalsOf(int ltr_number) const {
  std::vector<Triangle::Local> portals;
  for (int i = 0; i < ltr(ltr_number).first_portal[3]; ++i) {
    portals.push_back(localOf(ltr_number, portalAt(ltr_number, i)));
  }
  return portals;
}

std::vector<Triangle::Local> DoorGraph::wayBetween(int ltr_number, int from, int to) const {
  std::vector<Triangle::Local> way =
      ltr(ltr_number).matrix->turns(portalIn(ltr_number, from), portalIn(ltr_number, to));
  way.insert(way.begin(), localOf(ltr_number, from));
  way.push_back(localOf(ltr_number, to));
  return way;
}

std::uint64_t DoorGraph::doorOf(int portal) const {
  const GraphSide& of = side(sideOf(portal));
  const std::size_t index = std::size_t(portal - of.first_portal);
  for (const Door& door : of.doors->doors) {
    if (index < door.first_portal + door.portals) return door.id;
  }
  return 0;
}

void DoorGraph::spanBuckets(Frame& frame) const {
  Eigen::Vector2d low = ltrs_.front().view.corners[0], high = low;
  double extent = 0.0;
  for (const GraphLtr& ltr : ltrs_) {
    extent += std::sqrt(2.0 * std::abs(ltr.triangle.measure()));
    for (const Eigen::Vector2d& corner : ltr.view.corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  frame.low = low;
  double edge_m = std::max(extent / static_cast<double>(ltrs_.size()), 1e-3);
  // However far LTRs lie apart, there are not many more buckets than LTRs.
  const double limit = 16.0 * static_cast<double>(ltrs_.size()) + 64.0;
  while ((high - low).prod() / (edge_m * edge_m) > limit || (high - low).sum() / edge_m > limit) {
    edge_m *= 2.0;
  }
  frame.bucket_m = edge_m;
  const Eigen::Vector2i size = ((high - low) / edge_m).cast<int>() + Eigen::Vector2i::Ones();
  frame.bucket_columns = size.x();
  frame.bucket_rows = size.y();
}

void DoorGraph::fillBuckets(Frame& frame) const {
  const auto visitBuckets = [&](const GraphLtr& ltr, auto&& visit) {
    const Corners& c = ltr.view.corners;
    const Eigen::Vector2d least = c[0].cwiseMin(c[1]).cwiseMin(c[2]) - frame.low;
    const Eigen::Vector2d most = c[0].cwiseMax(c[1]).cwiseMax(c[2]) - frame.low;
    const Eigen::Vector2i from = (least / frame.bucket_m).cast<int>(),
                          to = (most / frame.bucket_m).cast<int>();
    for (int y = from.y(); y <= to.y(); ++y) {
      for (int x = from.x(); x <= to.x(); ++x) visit(std::size_t(y * frame.bucket_columns + x));
    }
  };
  std::vector<int>& starts = frame.bucket_starts;
  starts.assign(std::size_t(frame.bucket_columns) * std::size_t(frame.bucket_rows) + 1, 0);
  for (const GraphLtr& ltr : ltrs_) {
    visitBuckets(ltr, [&](std::size_t bucket) { ++starts[bucket + 1]; });
  }
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  frame.bucket_ltrs.resize(std::size_t(starts.back()));
  std::vector<int> next(starts.begin(), starts.end() - 1);
  for (std::size_t i = 0; i < ltrs_.size(); ++i) {
    visitBuckets(ltrs_[i], [&](std::size_t bucket) {
      frame.bucket_ltrs[std::size_t(next[bucket]++)] = static_cast<int>(i);
    });
  }
}

std::int64_t DoorGraph::bucketOf(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d place = (point - frame_->low) / frame_->bucket_m;
  if (!(place.minCoeff() >= 0.0) || place.x() >= frame_->bucket_columns ||
      place.y() >= frame_->bucket_rows) {
    return -1;
  }
  return std::int64_t(place.y()) * frame_->bucket_columns + std::int64_t(place.x());
}

int DoorGraph::locate(const Eigen::Vector2d& point) const {
  const std::int64_t bucket = bucketOf(point);
  if (bucket < 0) return kNone;
  const int begin = frame_->bucket_starts[std::size_t(bucket)],
            end = frame_->bucket_starts[std::size_t(bucket) + 1];
  for (int i = begin; i < end; ++i) {
    const int number = frame_->bucket_ltrs[std::size_t(i)];
    if (ltr(number).triangle.contains(point)) return number;
  }
  return kNone;
}

double DoorGraph::integrate(int start_ltr, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                            bool weighted) const {
  const double length_m = (to - from).norm();
  double sum = 0.0, at = 0.0;
  int number = start_ltr;
  // A line crosses each LTR once; more steps mean that rounding leads round a vertex.
  for (std::size_t steps = 0; steps <= ltrs_.size() && number != kNone; ++steps) {
    const GraphLtr& here = ltr(number);
    if (!here.costs) return kNoPassing;
    const Triangle::Local begin = here.triangle.toLocal(from);
    const Triangle::Local along = here.triangle.toLocal(to) - begin;
    double leave = 1.0;
    const int exit = exitOf(begin, along, at, leave);
    if (leave > at || exit == kNone) {
      sum +=
          (weighted ? here.factor : 1.0) *
          here.costs->integrate(begin + at * along, begin + leave * along, (leave - at) * length_m);
      if (sum == kNoPassing || exit == kNone) return sum;
    }
    at = leave;
    number = here.neighbours[std::size_t(exit)];
    if (number != kNone) {
      sum += (weighted ? ltr(number).factor : 1.0) *
             crossingCost(here, ltr(number), from + at * (to - from));
    }
  }
  return kNoPassing;
}

double DoorGraph::integrateFromAny(int start_ltr, const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& to, bool weighted) const {
  const double sum = integrate(start_ltr, from, to, weighted);
  const std::int64_t bucket = sum == kNoPassing ? bucketOf(from) : -1;
  if (bucket < 0) return sum;
  for (int i = frame_->bucket_starts[std::size_t(bucket)];
       i < frame_->bucket_starts[std::size_t(bucket) + 1]; ++i) {
    const int other = frame_->bucket_ltrs[std::size_t(i)];
    if (other == start_ltr || !ltr(other).triangle.contains(from)) continue;
    const double along = integrate(other, from, to, weighted);
    if (along < kNoPassing) return along;
  }
  return sum;
}

std::size_t DoorGraph::Frame::bytes() const {
  std::size_t sum = sizeof(*this) + sides.capacity() * sizeof(GraphSide) +
                    places.capacity() * (sizeof(Eigen::Vector2d) + sizeof(int)) +
                    search_sides.capacity() * sizeof(SearchSide) +
                    search_places.capacity() * sizeof(Eigen::Vector2f) +
                    crossings.capacity() * sizeof(float) +
                    (bucket_starts.capacity() + bucket_ltrs.capacity()) * sizeof(int);
  for (const GraphSide& side : sides) {
    if (!side.doors) continue;
    sum += sizeof(SideDoors) + side.doors->doors.capacity() * sizeof(Door) +
           side.doors->portals.capacity() * sizeof(double);
  }
  return sum;
}

std::size_t DoorGraph::bytes() const {
  std::size_t sum = sizeof(*this) + frame_->bytes() + ltrs_.capacity() * sizeof(GraphLtr) +
                    search_ltrs_.capacity() * sizeof(SearchLtr);
  for (const GraphLtr& ltr : ltrs_) {
    if (ltr.costs) sum += ltr.costs->bytes();
    if (ltr.matrix) sum += ltr.matrix->bytes();
  }
  return sum;
}

}  // namespace hymm::core
