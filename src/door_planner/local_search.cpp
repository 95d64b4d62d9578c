#include "door_planner/local_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hymm::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
/// Share by which a straight line may seem dearer than what it replaces, for rounding.
constexpr double kRounding = 1e-9;

}  // namespace

LocalSearch::LocalSearch(const Triangle& triangle, const CellCosts& costs, double max_metric_error)
    : costs_(costs),
      edges_(triangle.edges()),
      metric_(triangle, costs.grid().alphaCells(), costs.grid().betaCells(), max_metric_error) {}

double LocalSearch::integrate(const Triangle::Local& from, const Triangle::Local& to) const {
  return costs_.integrate(from, to, (edges_ * (to - from)).norm());
}

Triangle::Local LocalSearch::placeOf(int padded) const {
  const TriangularGrid& grid = costs_.grid();
  return {(padded % stride_ - pad_ + 0.5) / grid.alphaCells(),
          (padded / stride_ - pad_ + 0.5) / grid.betaCells()};
}

bool LocalSearch::hasItsCentreInside(int i, int j) const {
  const TriangularGrid& grid = costs_.grid();
  return (i + 0.5) / grid.alphaCells() + (j + 0.5) / grid.betaCells() <= 1.0 + kBorderTolerance;
}

void LocalSearch::prepare() {
  is_prepared_ = true;
  const std::vector<CellStep>& steps = metric_.steps();
  for (const CellStep& step : steps) pad_ = std::max({pad_, std::abs(step.di), std::abs(step.dj)});
  const TriangularGrid& grid = costs_.grid();
  stride_ = grid.alphaCells() + 2 * pad_;
  rows_ = grid.betaCells() + 2 * pad_;
  per_metre_.assign(std::size_t(stride_) * std::size_t(rows_), kInfinite);
  cells_.assign(per_metre_.size(), -1);
  first_step_.assign(per_metre_.size(), -1);
  int cell = 0;
  for (int j = 0; j < grid.betaCells(); ++j) {
    for (int i = 0; i < grid.rowLength(j); ++i, ++cell) {
      if (!costs_.isPassable(cell)) continue;
      const std::size_t place = std::size_t(paddedIndex(i, j));
      per_metre_[place] = costs_.perMetre(cell);
      if (hasItsCentreInside(i, j)) cells_[place] = cell;
    }
  }
  cheapest_step_ = kInfinite;
  for (const CellStep& step : steps) {
    cheapest_step_ = std::min(cheapest_step_, static_cast<float>(step.length_m));
    step_offsets_.push_back(step.dj * stride_ + step.di);
  }
  cheapest_step_ *= static_cast<float>(costs_.leastPerMetre());
}

// Made once: every search from one of the many portals of an LTR reads them.
const float* LocalSearch::stepsFrom(int padded) {
  const std::vector<CellStep>& steps = metric_.steps();
  int& first = first_step_[std::size_t(padded)];
  if (first < 0) {
    first = static_cast<int>(step_costs_.size());
    for (std::size_t k = 0; k < steps.size(); ++k) {
      float sum = 0.0F;
      if (cells_[std::size_t(padded + step_offsets_[k])] < 0) {
        sum = kInfinite;
      } else {
        for (const CellStep::Pass& pass : steps[k].passes) {
          sum += static_cast<float>(pass.share) *
                 per_metre_[std::size_t(padded + pass.dj * stride_ + pass.di)];
        }
      }
      step_costs_.push_back(sum * static_cast<float>(steps[k].length_m));
    }
  }
  return step_costs_.data() + first;
}

/// Cells around a place: the one that it lies in and those that touch it.
template <class Visitor>
void LocalSearch::visitNear(const Triangle::Local& place, Visitor&& visitor) const {
  const Eigen::Vector2d cells = costs_.grid().toCells(place);
  const int i0 = static_cast<int>(std::floor(cells.x())),
            j0 = static_cast<int>(std::floor(cells.y()));
  for (int j = j0 - 1; j <= j0 + 1; ++j) {
    if (j < 0 || j >= costs_.grid().betaCells()) continue;
    for (int i = i0 - 1; i <= i0 + 1; ++i) {
      if (i < 0 || i >= costs_.grid().rowLength(j) || !hasItsCentreInside(i, j)) continue;
      if (costs_.isPassable(costs_.grid().index(i, j))) visitor(paddedIndex(i, j));
    }
  }
}

LocalSearch::Link LocalSearch::bestLink(const Triangle::Local& other, Direction direction) const {
  Link best;
  visitNear(other, [&](int cell) {
    const double reached = static_cast<double>(labels_[std::size_t(cell)].cost);
    if (reached >= best.cost) return;
    const double cost = reached + oriented(placeOf(cell), other, direction);
    if (cost < best.cost) best = {cell, cost};
  });
  return best;
}

/// Cells at which the search may end; when all of them are reached it does.
void LocalSearch::aimAt(const std::vector<Triangle::Local>& others,
                        const std::vector<bool>& wanted) {
  is_end_.assign(labels_.size(), false);
  ends_ = 0;
  targets_.clear();
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (!wanted[i]) continue;
    targets_.push_back((edges_ * others[i]).cast<float>());
    visitNear(others[i], [&](int cell) {
      if (!is_end_[std::size_t(cell)]) ++ends_;
      is_end_[std::size_t(cell)] = true;
    });
  }
}

/// The cheapest ground as the crow flies to the nearest target.
float LocalSearch::boundOf(int cell) const {
  const Eigen::Vector2f here = (edges_ * placeOf(cell)).cast<float>();
  float nearest = kInfinite;
  for (const Eigen::Vector2f& target : targets_) {
    nearest = std::min(nearest, (target - here).squaredNorm());
  }
  // Rounded down, so that the bound stays one.
  return static_cast<float>(costs_.leastPerMetre() * (1.0 - 1e-5)) * std::sqrt(nearest);
}

void LocalSearch::push(float cost, int cell, int parent) {
  Label& label = labels_[std::size_t(cell)];
  if (cost >= label.cost) return;
  if (label.bound < 0.0F) label.bound = boundOf(cell);
  label.cost = cost;
  label.parent = parent;
  waiting_.push(cost + label.bound, cell);
}

void LocalSearch::takeUp(const CheapestFirst::Entry& entry, Direction direction) {
  const int cell = entry.value;
  const float cost = labels_[std::size_t(cell)].cost;
  if (entry.key > cost + labels_[std::size_t(cell)].bound) return;
  if (is_end_[std::size_t(cell)]) {
    is_end_[std::size_t(cell)] = false;
    --ends_;
  }
  const float* steps = stepsFrom(cell);
  for (std::size_t k = 0; k < step_offsets_.size(); ++k) {
    float step = steps[k];
    if (!(step < kInfinite)) continue;
    const int next = cell + step_offsets_[k];
    if (costs_.isDirected()) {
      const int here = cells_[std::size_t(cell)], there = cells_[std::size_t(next)];
      step +=
          direction == Direction::kFrom ? costs_.passing(here, there) : costs_.passing(there, here);
    }
    push(cost + step, next, cell);
  }
}

/// A*.
void LocalSearch::spread(const Triangle::Local& place, Direction direction,
                         const std::vector<Triangle::Local>& others,
                         const std::vector<bool>& wanted) {
  labels_.assign(std::size_t(stride_) * std::size_t(rows_), Label{kInfinite, -1, -1.0F});
  // Buckets as wide as a step is cheap at least: what is taken up too early is taken up again.
  waiting_.begin(0.0F, cheapest_step_);
  aimAt(others, wanted);
  visitNear(place, [&](int cell) {
    push(static_cast<float>(oriented(place, placeOf(cell), direction)), cell, -1);
  });
  CheapestFirst::Entry entry{};
  while ((ends_ > 0 || !waiting_.isThrough()) && waiting_.pop(entry)) takeUp(entry, direction);
}

LocalPath LocalSearch::trace(const Triangle::Local& place, const Triangle::Local& other,
                             Direction direction) const {
  const Link end = bestLink(other, direction);
  if (end.cell < 0) return {};
  std::vector<Triangle::Local> points{other};
  for (int cell = end.cell; cell >= 0; cell = labels_[std::size_t(cell)].parent) {
    points.push_back(placeOf(cell));
  }
  points.push_back(place);
  if (direction == Direction::kFrom) std::reverse(points.begin(), points.end());
  return pulled(points);
}

LocalPath LocalSearch::pulled(const std::vector<Triangle::Local>& points) const {
  LocalPath path;
  path.points.push_back(points.front());
  path.cost = 0.0;
  std::size_t anchor = 0;
  while (anchor + 1 < points.size()) {
    double along = integrate(points[anchor], points[anchor + 1]);
    double best = along;
    std::size_t reached = anchor + 1;
    for (std::size_t next = anchor + 2; next < points.size(); ++next) {
      along += integrate(points[next - 1], points[next]);
      const double straight = integrate(points[anchor], points[next]);
      if (straight > along * (1.0 + kRounding)) break;
      best = along = straight;
      reached = next;
    }
    if (best == kNoPassing) return {};
    path.cost += best;
    path.points.push_back(points[reached]);
    anchor = reached;
  }
  return path;
}

std::vector<LocalPath> LocalSearch::find(const Triangle::Local& place,
                                         const std::vector<Triangle::Local>& others,
                                         Direction direction) {
  std::vector<LocalPath> paths(others.size());
  std::vector<bool> wanted(others.size(), false);
  bool any = false;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const double cost = oriented(place, others[i], direction);
    if (cost < kNoPassing) paths[i] = {cost, {place, others[i]}};
    // Nothing inside a triangle is cheaper than a straight line over its cheapest ground.
    const double least = (edges_ * (others[i] - place)).norm() * costs_.leastPerMetre();
    wanted[i] = !(cost <= least * (1.0 + 1e-6));
    any = any || wanted[i];
    if (direction == Direction::kTo) std::reverse(paths[i].points.begin(), paths[i].points.end());
  }
  if (!any) return paths;
  if (!is_prepared_) prepare();
  spread(place, direction, others, wanted);
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (!wanted[i]) continue;
    LocalPath around = trace(place, others[i], direction);
    if (around.cost < paths[i].cost) paths[i] = std::move(around);
  }
  return paths;
}

}  // namespace hymm::core
