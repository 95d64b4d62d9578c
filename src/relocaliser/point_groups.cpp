#include "relocaliser/point_groups.h"

#include <algorithm>
#include <iterator>

#include <Eigen/Geometry>

namespace hymm::core {
namespace {

PointGroup makeGroup(const std::vector<ArmPoint>& points, std::size_t begin, std::size_t end,
                     const Eigen::AlignedBox2d& box) {
  PointGroup group;
  group.begin = begin;
  group.end = end;
  group.arm = box.center();
  for (std::size_t k = begin; k < end; ++k) {
    group.within_m = std::max(group.within_m, (points[k].arm - group.arm).norm());
    group.longest_m = std::max(group.longest_m, points[k].arm.norm());
    group.is_of_one_class &= points[k].deviation == points[begin].deviation;
  }
  return group;
}

}  // namespace

PointTree::PointTree(std::vector<ArmPoint>& points) { divide(points, 0, points.size()); }

/// By the middle of the box around them, across its longer side, so that points of one landmark
/// stay together for long.
std::size_t PointTree::divide(std::vector<ArmPoint>& points, std::size_t begin, std::size_t end) {
  Eigen::AlignedBox2d box;
  for (std::size_t k = begin; k < end; ++k) box.extend(points[k].arm);
  const std::size_t number = nodes_.size();
  nodes_.push_back({makeGroup(points, begin, end, box)});
  const PointGroup& group = nodes_[number].group;
  const Eigen::Index axis = box.sizes().x() >= box.sizes().y() ? 0 : 1;
  const auto first_at = points.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto end_at = points.begin() + static_cast<std::ptrdiff_t>(end);
  auto half = std::stable_partition(
      first_at, end_at, [&](const ArmPoint& p) { return p.arm[axis] < group.arm[axis]; });
  // At one place, or at neighbouring numbers, there are no halves.
  const auto is_whole = [&] { return half == first_at || half == end_at; };
  if (is_whole() && !group.is_of_one_class) {
    const std::size_t deviation = first_at->deviation;
    half = std::stable_partition(first_at, end_at,
                                 [&](const ArmPoint& p) { return p.deviation == deviation; });
  }
  if (is_whole()) return number;
  const auto middle = static_cast<std::size_t>(std::distance(points.begin(), half));
  const std::size_t first = divide(points, begin, middle);
  const std::size_t second = divide(points, middle, end);
  nodes_[number].first = first;
  nodes_[number].second = second;
  return number;
}

std::vector<PointGroup> PointTree::cut(
    const std::function<bool(const PointGroup&)>& is_accepted) const {
  std::vector<PointGroup> groups;
  std::vector<std::size_t> open{0};
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    open.pop_back();
    if (node.first == 0 || is_accepted(node.group)) {
      groups.push_back(node.group);
    } else {
      open.push_back(node.second);
      open.push_back(node.first);
    }
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const PointGroup& a, const PointGroup& b) { return a.size() > b.size(); });
  return groups;
}

}  // namespace hymm::core
