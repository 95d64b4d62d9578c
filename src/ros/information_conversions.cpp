#include "ros/information_conversions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "ros/time_conversions.h"

namespace hymm {
namespace {

using Eigen::Vector2d;
using visualization_msgs::Marker;

constexpr double kBorderWidth_m = 0.3;
constexpr double kTextHeight_m = 4.0;

/// From blue (lowest value) to yellow (highest).
std_msgs::ColorRGBA colourOf(std::size_t set, std::size_t sets) {
  const float share = sets < 2 ? 0.0F : static_cast<float>(set) / static_cast<float>(sets - 1);
  std_msgs::ColorRGBA colour;
  colour.r = 0.15F + 0.85F * share;
  colour.g = 0.45F + 0.40F * share;
  colour.b = 0.95F - 0.80F * share;
  colour.a = 0.9F;
  return colour;
}

geometry_msgs::Point pointAt(const Vector2d& place) {
  geometry_msgs::Point point;
  point.x = place.x();
  point.y = place.y();
  return point;
}

Marker markerOf(const core::LevelSets& sets, const std::string& frame_id, const char* name,
                int type) {
  Marker marker;
  marker.header.stamp = toRosTime(sets.time_s);
  marker.header.frame_id = frame_id;
  marker.ns = name;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  return marker;
}

/// Sides of smallest leaves that only one leaf has, as pairs of points.
std::vector<geometry_msgs::Point> borderOf(const core::LevelSet& set, double resolution_m) {
  using Side = std::pair<std::int64_t, std::int64_t>;
  // Horizontal and vertical unit sides by their least corner, with the number of leaves at them.
  std::map<Side, int> horizontal, vertical;
  for (const core::LevelLeaf& leaf : set.leaves) {
    const auto n = static_cast<std::int64_t>(std::lround(leaf.edge_m / resolution_m));
    const Vector2d low = leaf.centre - Vector2d::Constant(0.5 * leaf.edge_m);
    const auto x = static_cast<std::int64_t>(std::lround(low.x() / resolution_m));
    const auto y = static_cast<std::int64_t>(std::lround(low.y() / resolution_m));
    for (std::int64_t i = 0; i < n; ++i) {
      ++horizontal[{x + i, y}];
      ++horizontal[{x + i, y + n}];
      ++vertical[{x, y + i}];
      ++vertical[{x + n, y + i}];
    }
  }
  std::vector<geometry_msgs::Point> points;
  const auto add = [&](const std::map<Side, int>& sides, const Vector2d& along) {
    for (const auto& [side, leaves] : sides) {
      if (leaves != 1) continue;
      const Vector2d from(static_cast<double>(side.first), static_cast<double>(side.second));
      points.push_back(pointAt(from * resolution_m));
      points.push_back(pointAt((from + along) * resolution_m));
    }
  };
  add(horizontal, Vector2d::UnitX());
  add(vertical, Vector2d::UnitY());
  return points;
}

}  // namespace

LevelSet toMessage(const core::LevelSets& sets, const core::LevelSet& set, bool complete,
                   const std::string& frame_id) {
  LevelSet message;
  message.header.stamp = toRosTime(sets.time_s);
  message.header.frame_id = frame_id;
  message.value = set.value;
  message.map_version = sets.map_version;
  message.computed_version = sets.computed_version;
  message.complete = complete && sets.map_version == sets.computed_version;
  message.resolution = sets.resolution_m;
  message.area = set.area_m2;
  message.leaves.reserve(set.leaves.size());
  for (const core::LevelLeaf& leaf : set.leaves) {
    LevelSetLeaf square;
    square.x = static_cast<float>(leaf.centre.x());
    square.y = static_cast<float>(leaf.centre.y());
    square.edge = static_cast<float>(leaf.edge_m);
    square.island = leaf.island;
    message.leaves.push_back(square);
  }
  for (const core::Island& island : set.islands) {
    LevelSetIsland part;
    part.id = island.id;
    part.area = static_cast<float>(static_cast<double>(island.cells) * sets.resolution_m *
                                   sets.resolution_m);
    message.islands.push_back(part);
  }
  message.vehicle_island = set.vehicle_island;
  return message;
}

core::LevelSet fromMessage(const LevelSet& message) {
  core::LevelSet set;
  set.value = message.value;
  set.area_m2 = message.area;
  set.vehicle_island = message.vehicle_island;
  // Numbers of the message are single; those of the lattice are multiples of half its squares.
  const auto onLattice = [&](float coordinate) {
    const double half = 0.5 * message.resolution;
    return half > 0.0 ? std::round(static_cast<double>(coordinate) / half) * half
                      : static_cast<double>(coordinate);
  };
  for (const LevelSetLeaf& leaf : message.leaves) {
    set.leaves.push_back(
        {{onLattice(leaf.x), onLattice(leaf.y)}, onLattice(leaf.edge), leaf.island});
  }
  return set;
}

ExplorationGoal toMessage(const core::ExplorationGoal& goal) {
  ExplorationGoal message;
  message.goal.x = goal.T_map_base.x_m;
  message.goal.y = goal.T_map_base.y_m;
  message.goal.theta = goal.T_map_base.yaw_rad;
  for (const Vector2d& place : goal.way) message.way.push_back(pointAt(place));
  message.way_length = goal.way_m;
  message.position_deviation = goal.position_deviation_m;
  message.heading_deviation = goal.heading_deviation_rad;
  message.new_area = goal.new_area_m2;
  message.joins_island = goal.joins_island;
  return message;
}

visualization_msgs::MarkerArray islandMarkers(const core::LevelSets& sets,
                                              const std::string& frame_id) {
  visualization_msgs::MarkerArray markers;
  Marker clear = markerOf(sets, frame_id, "island", Marker::TEXT_VIEW_FACING);
  clear.action = Marker::DELETEALL;
  markers.markers.push_back(clear);
  for (std::size_t i = 0; i < sets.sets.size(); ++i) {
    const core::LevelSet& set = sets.sets[i];
    Marker border = markerOf(sets, frame_id, "border", Marker::LINE_LIST);
    border.id = static_cast<int>(i);
    border.scale.x = kBorderWidth_m;
    border.color = colourOf(i, sets.sets.size());
    border.points = borderOf(set, sets.resolution_m);
    if (!border.points.empty()) markers.markers.push_back(border);
    if (i > 0) continue;  // ids of the lowest value's islands only
    for (const core::Island& island : set.islands) {
      Marker text = markerOf(sets, frame_id, "island", Marker::TEXT_VIEW_FACING);
      text.id = island.id;
      text.scale.z = kTextHeight_m;
      text.color = border.color;
      text.text = std::to_string(island.id);
      text.pose.position.x = (island.first.x + 0.5) * sets.resolution_m;
      text.pose.position.y = (island.first.y + 0.5) * sets.resolution_m;
      markers.markers.push_back(text);
    }
  }
  return markers;
}

}  // namespace hymm
