#include "ros/cloud_conversions.h"

#include <algorithm>
#include <vector>

#include <boost/make_shared.hpp>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "ros/parameters.h"
#include "ros/sensor_conversions.h"

namespace hymm {
namespace {

std::string listOf(const std::vector<sensor_msgs::PointField>& fields) {
  std::string list;
  for (const sensor_msgs::PointField& field : fields) {
    list += (list.empty() ? "" : ", ") + field.name;
  }
  return list.empty() ? "none" : list;
}

/// Why a coordinate cannot be read; empty if it can.
std::string fieldProblem(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  if (field == cloud.fields.end()) {
    return "it has no field '" + name + "'; it has " + listOf(cloud.fields);
  }
  if (field->datatype != sensor_msgs::PointField::FLOAT32 || field->count > 1U) {
    return "its field '" + name + "' is not one FLOAT32";
  }
  if (std::size_t{field->offset} + sizeof(float) > cloud.point_step) {
    return "its field '" + name + "' lies outside of point_step";
  }
  return "";
}

/// Why the points cannot be read; empty if they can.
std::string layoutProblem(const sensor_msgs::PointCloud2& cloud) {
  for (const char* name : {"x", "y", "z"}) {
    std::string problem = fieldProblem(cloud, name);
    if (!problem.empty()) return problem;
  }
  if (cloud.is_bigendian != 0U) return "it is big-endian";
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  if (cloud.row_step != row || cloud.data.size() != row * cloud.height) {
    return "its data do not have the size that width, height and steps tell";
  }
  return "";
}

/// From the cloud's axes to upright ones at the sensor, z from base_link up.
Eigen::Isometry3f uprightFrom(const SensorMountings::Answer& mounting) {
  Eigen::Isometry3d upright = Eigen::Isometry3d::Identity();
  upright.translation().z() = mounting.T_base_frame.translation().z();
  upright.linear() = Eigen::AngleAxisd(-mounting.T_base_sensor->yaw_rad, Eigen::Vector3d::UnitZ()) *
                     mounting.T_base_frame.linear();
  return upright.cast<float>();
}

std::vector<Eigen::Vector3f> pointsOf(const sensor_msgs::PointCloud2& cloud,
                                      const Eigen::Isometry3f& T_upright_cloud) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(std::size_t{cloud.width} * cloud.height);
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (; x != x.end(); ++x, ++y, ++z) {
    points.emplace_back(T_upright_cloud * Eigen::Vector3f(*x, *y, *z));
  }
  return points;
}

}  // namespace

CloudScan scanOfCloud(const sensor_msgs::PointCloud2& cloud,
                      const SensorMountings::Answer& mounting,
                      const core::PointCloudConfig& config) {
  const std::string& frame = cloud.header.frame_id;
  CloudScan result;
  if (!mounting.T_base_sensor) {
    result.cause = "unknown frame '" + frame + "'";
    result.problem = "Point clouds of frame '" + frame + "' are refused: " + mounting.problem + ".";
    return result;
  }
  const std::string problem = layoutProblem(cloud);
  if (!problem.empty()) {
    result.cause = "point clouds that cannot be read";
    result.problem = "A point cloud of frame '" + frame + "' is refused: " + problem + ".";
    return result;
  }
  const auto scan = boost::make_shared<sensor_msgs::LaserScan>(
      toMessage(core::scanOfPoints(pointsOf(cloud, uprightFrom(mounting)),
                                   cloud.header.stamp.toSec(), config),
                frame));
  scan->header = cloud.header;
  result.scan = scan;
  return result;
}

core::PointCloudConfig readPointClouds(const ros::NodeHandle& handle, core::ConfigReport& report) {
  core::PointCloudConfig config;
  std::string parameter;
  XmlRpc::XmlRpcValue value;
  if (handle.searchParam("point_clouds", parameter) && handle.getParam(parameter, value)) {
    core::readConfig(toYaml(value), config, parameter, report);
  }
  return config;
}

}  // namespace hymm
