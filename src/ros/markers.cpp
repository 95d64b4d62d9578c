#include "ros/markers.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "common/angles.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

using visualization_msgs::Marker;

constexpr int kEllipseSides = 24;
constexpr double kEllipseSigmas = 2.0;
constexpr double kLineWidth_m = 0.02;  // finer than the ellipse of a landmark seen often
constexpr double kMagnification = 10.0;
constexpr double kMagnifiedLineWidth_m = 0.15;
constexpr double kEllipseHeight_m = 0.12;  // above the discs, seen from above
constexpr double kRayWidth_m = 0.1;
constexpr double kSmallestDisc_m = 0.6;  // so that a pole stays visible from above

std_msgs::ColorRGBA colour(float r, float g, float b, float a = 1.0F) {
  std_msgs::ColorRGBA message;
  message.r = r;
  message.g = g;
  message.b = b;
  message.a = a;
  return message;
}

std_msgs::ColorRGBA colourOf(core::LandmarkType type) {
  switch (type) {
    case core::LandmarkType::kTrunk:
      return colour(0.20F, 0.75F, 0.30F);
    case core::LandmarkType::kReflector:
      return colour(0.95F, 0.65F, 0.15F);
    case core::LandmarkType::kUnknown:
      break;
  }
  return colour(0.60F, 0.65F, 0.75F);
}

std_msgs::ColorRGBA colourOf(const core::Association& association) {
  if (association.landmark_id >= 0) return colour(0.25F, 0.95F, 0.35F, 0.8F);
  if (association.landmark_id == core::Association::kTentative) {
    return colour(0.95F, 0.85F, 0.20F, 0.8F);
  }
  return colour(0.95F, 0.25F, 0.20F, 0.8F);
}

geometry_msgs::Point pointAt(const Eigen::Vector2d& position) {
  geometry_msgs::Point point;
  point.x = position.x();
  point.y = position.y();
  return point;
}

Marker listMarker(const char* name, int type, double scale_m, double time_s,
                  const std::string& frame_id) {
  Marker marker;
  marker.header.stamp = toRosTime(time_s);
  marker.header.frame_id = frame_id;
  marker.ns = name;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = scale_m;
  marker.color = colour(1.0F, 1.0F, 1.0F);
  return marker;
}

void addEllipse(const core::LandmarkEstimate& landmark, double magnification, Marker& lines) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(landmark.covariance);
  const Eigen::Vector2d axes =
      magnification * kEllipseSigmas * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Eigen::Matrix2d shape = eigen.eigenvectors() * axes.asDiagonal();
  const auto corner = [&](int side) {
    const double angle = 2.0 * core::kPi * side / kEllipseSides;
    return pointAt(landmark.position + shape * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  };
  for (int side = 0; side < kEllipseSides; ++side) {
    lines.points.push_back(corner(side));
    lines.points.push_back(corner(side + 1));
  }
}

Marker disc(const core::LandmarkEstimate& landmark, double time_s, const std::string& frame_id) {
  const double diameter_m =
      std::isfinite(landmark.diameter_m) ? landmark.diameter_m : kSmallestDisc_m;
  Marker marker = listMarker("landmarks", Marker::CYLINDER, std::max(diameter_m, kSmallestDisc_m),
                             time_s, frame_id);
  marker.id = landmark.id;
  marker.pose.position = pointAt(landmark.position);
  marker.scale.z = 0.1;
  marker.color = colourOf(landmark.type);
  return marker;
}

}  // namespace

visualization_msgs::MarkerArray landmarkMarkers(const core::LandmarkMap& map,
                                                const std::string& frame_id) {
  visualization_msgs::MarkerArray markers;
  Marker clear;
  clear.action = Marker::DELETEALL;  // landmarks disappear, too
  markers.markers.push_back(clear);
  Marker ellipses = listMarker("two_sigma", Marker::LINE_LIST, kLineWidth_m, map.time_s, frame_id);
  ellipses.pose.position.z = kEllipseHeight_m;
  ellipses.color = colour(0.05F, 0.20F, 0.60F);
  Marker magnified = listMarker("two_sigma_magnified_10x", Marker::LINE_LIST, kMagnifiedLineWidth_m,
                                map.time_s, frame_id);
  magnified.color = colour(0.35F, 0.70F, 1.0F);
  for (const core::LandmarkEstimate& landmark : map.landmarks) {
    addEllipse(landmark, 1.0, ellipses);
    addEllipse(landmark, kMagnification, magnified);
    markers.markers.push_back(disc(landmark, map.time_s, frame_id));
  }
  if (!ellipses.points.empty())
    markers.markers.insert(markers.markers.end(), {ellipses, magnified});
  return markers;
}

visualization_msgs::MarkerArray observationMarkers(const core::ScanOutcome& outcome,
                                                   const std::string& frame_id) {
  const core::Pose2 T_map_sensor = outcome.pose.T_map_base * outcome.observations.T_base_sensor;
  Marker rays =
      listMarker("observations", Marker::LINE_LIST, kRayWidth_m, outcome.pose.time_s, frame_id);
  const auto& observations = outcome.observations.observations;
  for (std::size_t i = 0; i < observations.size() && i < outcome.associations.size(); ++i) {
    const core::Observation& observation = observations[i];
    const Eigen::Vector2d p_sensor(observation.range_m * std::cos(observation.bearing_rad),
                                   observation.range_m * std::sin(observation.bearing_rad));
    rays.points.push_back(pointAt(T_map_sensor.position()));
    rays.points.push_back(pointAt(T_map_sensor * p_sensor));
    rays.colors.insert(rays.colors.end(), 2, colourOf(outcome.associations[i]));
  }
  if (rays.points.empty()) rays.action = Marker::DELETE;
  visualization_msgs::MarkerArray markers;
  markers.markers.push_back(rays);
  return markers;
}

}  // namespace hymm
