// How a DoorMap becomes the DoorGraph that queries use.

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "door_planner/door_map.h"

namespace hymm::core {
namespace {

/// Largest share by which a length in `before` has grown in `now`.
double stretchOf(const Triangle& now, const Triangle& before) {
  const Eigen::Matrix2d deformation = now.edges() * before.edgesInverse();
  // The larger singular value, by the trace and the determinant of its square.
  const double trace = deformation.squaredNorm(), determinant = deformation.determinant();
  const double root = std::sqrt(std::max(0.0, trace * trace - 4.0 * determinant * determinant));
  return std::sqrt(0.5 * (trace + root));
}

}  // namespace

std::shared_ptr<const DoorGraph> DoorMap::makeGraph() {
  std::shared_ptr<const DoorGraph> made;
  if (graph_ && !is_reshaped_) made = makeByChanges();
  graph_ = made ? made : makeWhole();
  is_reshaped_ = false;
  changed_.clear();
  return graph_;
}

std::shared_ptr<const DoorGraph> DoorMap::makeByChanges() const {
  const std::vector<GraphLtr>& ltrs = graph_->ltrs();
  std::vector<GraphChange> changes;
  for (const int id : changed_) {
    const Region& region = regions_.at(id);
    const auto place =
        std::lower_bound(ltrs.begin(), ltrs.end(), id,
                         [](const GraphLtr& ltr, int wanted) { return ltr.view.id < wanted; });
    GraphChange change;
    change.ltr = static_cast<int>(place - ltrs.begin());
    change.costs = region.in_force;
    if (to_compute_.count(id) == 0) change.matrix = region.matrix;
    if (region.in_force) change.stretch = stretchOf(region.triangle, region.computed);
    changes.push_back(std::move(change));
  }
  return graph_->with(changes);
}

std::shared_ptr<const DoorGraph> DoorMap::makeWhole() const {
  std::vector<GraphLtr> ltrs;
  std::unordered_map<int, int> numbers;
  ltrs.reserve(regions_.size());
  for (const auto& [id, region] : regions_) {
    numbers[id] = static_cast<int>(ltrs.size());
    GraphLtr ltr;
    ltr.view = region.view;
    ltr.triangle = region.triangle;
    ltr.factor = region.view.factor();
    ltr.costs = region.in_force;
    if (to_compute_.count(id) == 0) ltr.matrix = region.matrix;
    if (region.in_force) ltr.stretch = stretchOf(region.triangle, region.computed);
    ltrs.push_back(std::move(ltr));
  }
  for (GraphLtr& ltr : ltrs) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto neighbour = numbers.find(ltr.view.neighbours[k]);
      if (neighbour != numbers.end()) ltr.neighbours[k] = neighbour->second;
    }
  }
  std::vector<GraphSide> sides;
  sides.reserve(sides_.size());
  for (const auto& [key, side] : sides_) {
    GraphSide added;
    added.doors = side.doors;
    for (std::size_t i = 0; i < 2; ++i) {
      added.ltrs[i] = numbers.at(side.ltrs[i]);
      GraphLtr& ltr = ltrs[std::size_t(added.ltrs[i])];
      ltr.sides[std::size_t(findSide(ltr.view, key))] = static_cast<int>(sides.size());
    }
    sides.push_back(std::move(added));
  }
  return std::make_shared<DoorGraph>(std::move(ltrs), std::move(sides), config_.max_metric_error);
}

}  // namespace hymm::core
