#include "ros/plan_conversions.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <geometry_msgs/PoseStamped.h>

#include "ros/pose_conversions.h"

namespace hymm {
namespace {

std::uint64_t keyOf(double x, double y, double bucket_m) {
  const auto column = static_cast<std::int32_t>(std::floor(x / bucket_m));
  const auto row = static_cast<std::int32_t>(std::floor(y / bucket_m));
  return std::uint64_t{static_cast<std::uint32_t>(column)} << 32U | static_cast<std::uint32_t>(row);
}

visualization_msgs::Marker marker(const std_msgs::Header& header, const std::string& name, int type,
                                  double scale_m) {
  visualization_msgs::Marker made;
  made.header = header;
  made.ns = name;
  made.type = type;
  made.action = visualization_msgs::Marker::ADD;
  made.pose.orientation.w = 1.0;
  made.scale.x = made.scale.y = scale_m;
  made.color.a = 0.9F;
  made.color.g = 0.7F;
  made.color.b = 1.0F;
  return made;
}

geometry_msgs::Point pointOf(const Eigen::Vector2d& place) {
  geometry_msgs::Point point;
  point.x = place.x();
  point.y = place.y();
  return point;
}

/// From green, as cheap as the cheapest ground, to red, four times as dear.
std_msgs::ColorRGBA colourOf(double dearness) {
  const auto share = static_cast<float>(std::clamp((dearness - 1.0) / 3.0, 0.0, 1.0));
  std_msgs::ColorRGBA colour;
  colour.r = share;
  colour.g = 1.0F - share;
  colour.a = 0.6F;
  return colour;
}

/// Lines between the doors of an LTR, from middle to middle, coloured by what a metre costs there.
void addCosts(const core::DoorGraph& graph, int number, visualization_msgs::Marker& costs) {
  const core::GraphLtr& ltr = graph.ltr(number);
  if (!ltr.matrix) return;
  std::vector<int> middles;
  for (const int side : ltr.sides) {
    if (side == core::kNone) continue;
    for (const core::Door& door : graph.side(side).doors->doors) {
      middles.push_back(graph.side(side).first_portal +
                        static_cast<int>(door.first_portal + door.portals / 2));
    }
  }
  for (const int from : middles) {
    for (const int to : middles) {
      const double length_m = (graph.placeOf(to) - graph.placeOf(from)).norm();
      const double cost =
          ltr.factor * static_cast<double>(ltr.matrix->cost(graph.portalIn(number, from),
                                                            graph.portalIn(number, to)));
      if (from >= to || !std::isfinite(cost) || !(length_m > 0.0)) continue;
      costs.points.push_back(pointOf(graph.placeOf(from)));
      costs.points.push_back(pointOf(graph.placeOf(to)));
      costs.colors.resize(costs.points.size(), colourOf(cost / (length_m * graph.leastPerMetre())));
    }
  }
}

}  // namespace

nav_msgs::Path pathMessage(const std::vector<Eigen::Vector2d>& path, const std_msgs::Header& header,
                           const std::vector<core::PlanPoint>& points) {
  nav_msgs::Path message;
  message.header = header;
  double yaw = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i + 1 < path.size()) {
      const Eigen::Vector2d along = path[i + 1] - path[i];
      yaw = std::atan2(along.y(), along.x());
      if (i + 1 < points.size() && points[i + 1].is_backwards) yaw += M_PI;
    }
    geometry_msgs::PoseStamped pose;
    pose.header = header;
    pose.pose.position = pointOf(path[i]);
    pose.pose.orientation.z = std::sin(0.5 * yaw);
    pose.pose.orientation.w = std::cos(0.5 * yaw);
    message.poses.push_back(pose);
  }
  return message;
}

visualization_msgs::MarkerArray doorMarkers(const core::DoorGraph& graph,
                                            const std_msgs::Header& header) {
  visualization_msgs::Marker doors =
      marker(header, "doors", visualization_msgs::Marker::LINE_LIST, 0.1);
  visualization_msgs::Marker portals =
      marker(header, "portals", visualization_msgs::Marker::POINTS, 0.25);
  for (const core::GraphLtr& ltr : graph.ltrs()) {
    for (int k = 0; k < 3; ++k) {
      const int number = ltr.sides[std::size_t(k)];
      // Each side once: from the LTR that comes first.
      if (number == core::kNone || &graph.ltr(graph.side(number).ltrs[0]) != &ltr) continue;
      for (const core::Door& door : graph.side(number).doors->doors) {
        for (const double at : {door.from, door.to}) {
          doors.points.push_back(
              pointOf(ltr.triangle.toGlobal(core::placeOnSide(ltr.view, k, at))));
        }
      }
    }
  }
  visualization_msgs::Marker costs =
      marker(header, "costs", visualization_msgs::Marker::LINE_LIST, 0.05);
  for (std::size_t number = 0; number < graph.ltrs().size(); ++number) {
    addCosts(graph, static_cast<int>(number), costs);
  }
  for (int portal = 0; portal < graph.portalCount(); ++portal) {
    portals.points.push_back(pointOf(graph.placeOf(portal)));
  }
  visualization_msgs::MarkerArray markers;
  markers.markers = {doors, portals, costs};
  return markers;
}

InformedPlaces::InformedPlaces(const LevelSet& message) : value_(message.value) {
  double largest = 0.1;
  for (const LevelSetLeaf& leaf : message.leaves) {
    largest = std::max(largest, static_cast<double>(leaf.edge));
  }
  bucket_m_ = largest;
  for (const LevelSetLeaf& leaf : message.leaves) {
    const Leaf added{static_cast<double>(leaf.x), static_cast<double>(leaf.y),
                     0.5 * static_cast<double>(leaf.edge)};
    // No leaf is wider than a bucket: its corners tell all that it touches.
    std::vector<std::uint64_t> keys;
    for (const double x : {added.x - added.half, added.x + added.half}) {
      for (const double y : {added.y - added.half, added.y + added.half}) {
        keys.push_back(keyOf(x, y, bucket_m_));
      }
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    for (const std::uint64_t key : keys) buckets_[key].push_back(added);
  }
}

bool InformedPlaces::contains(const Eigen::Vector2d& place) const {
  const auto bucket = buckets_.find(keyOf(place.x(), place.y(), bucket_m_));
  if (bucket == buckets_.end()) return false;
  return std::any_of(bucket->second.begin(), bucket->second.end(), [&](const Leaf& leaf) {
    return std::abs(place.x() - leaf.x) <= leaf.half && std::abs(place.y() - leaf.y) <= leaf.half;
  });
}

}  // namespace hymm
