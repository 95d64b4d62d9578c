#include "ros/cloud_conversions.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

#include "ros/parameters.h"
#include "ros/point_fields.h"
#include "ros/point_times.h"
#include "ros/time_conversions.h"

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
  const sensor_msgs::PointField* field = findField(cloud, name);
  if (field == nullptr) return "it has no field '" + name + "'; it has " + listOf(cloud.fields);
  const bool is_float = field->datatype == sensor_msgs::PointField::FLOAT32 ||
                        field->datatype == sensor_msgs::PointField::FLOAT64;
  if (!is_float || !isReadable(*field)) {
    return "its field '" + name + "' is not one FLOAT32 or FLOAT64";
  }
  if (!isInside(*field, cloud)) {
    return "its field '" + name + "' lies outside of point_step";
  }
  return "";
}

/// Why the points cannot be read; empty if they can. Rows may be padded, the last one need not be.
std::string layoutProblem(const sensor_msgs::PointCloud2& cloud) {
  for (const char* name : {"x", "y", "z"}) {
    std::string problem = fieldProblem(cloud, name);
    if (!problem.empty()) return problem;
  }
  if (cloud.width == 0U || cloud.height == 0U) return "";
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  const std::size_t needed = std::size_t{cloud.row_step} * (cloud.height - 1U) + row;
  if (cloud.row_step < row || cloud.data.size() < needed) {
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
  if (cloud.data.empty()) return points;
  points.reserve(std::size_t{cloud.width} * cloud.height);
  const NumberField x(cloud, *findField(cloud, "x"));
  const NumberField y(cloud, *findField(cloud, "y"));
  const NumberField z(cloud, *findField(cloud, "z"));
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data.data() + row * cloud.row_step;
    for (std::size_t i = 0; i < cloud.width; ++i, point += cloud.point_step) {
      const Eigen::Vector3d place(x.of(point), y.of(point), z.of(point));
      points.emplace_back(T_upright_cloud * place.cast<float>());
    }
  }
  return points;
}

/// Says so where a cloud has points, but none at the heights of obstacles: a laser that stands
/// lower than these would otherwise look like one that sees nothing.
void remarkOnHeights(const std::vector<Eigen::Vector3f>& points,
                     const core::PointCloudConfig& config, const std::string& frame,
                     CloudScan& result) {
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) continue;
    lowest = std::min(lowest, point.z());
    highest = std::max(highest, point.z());
  }
  const double top_m = config.min_height_m + config.band_height_m;
  const bool is_beside =
      static_cast<double>(highest) < config.min_height_m || static_cast<double>(lowest) > top_m;
  if (lowest > highest || !is_beside) return;
  std::ostringstream sentence;
  sentence << "All points of a cloud of frame '" << frame << "' are " << lowest << " to " << highest
           << " m above base_link, and none counts as an obstacle: point_clouds says from "
           << config.min_height_m << " to " << top_m
           << " m. Set min_height_m, or check the static transform.";
  result.remarks.push_back(
      {"point clouds without a point at the heights of obstacles", sentence.str()});
}

/// The scan, which begins with its first point: the stamp of a cloud may be of its last one.
HeadedScan headedScan(const std_msgs::Header& header, const std::vector<Eigen::Vector3f>& points,
                      std::vector<double> after_stamp_s, const core::PointCloudConfig& config) {
  HeadedScan headed{header, header.stamp, {}};
  const double first_s =
      after_stamp_s.empty() ? 0.0 : *std::min_element(after_stamp_s.begin(), after_stamp_s.end());
  if (first_s < 0.0) headed.header.stamp = toRosTime(header.stamp.toSec() + first_s);
  std::vector<float> times_s;
  times_s.reserve(after_stamp_s.size());
  for (const double time_s : after_stamp_s) {
    times_s.push_back(static_cast<float>(time_s - std::min(first_s, 0.0)));
  }
  headed.scan = core::scanOfPoints(points, headed.header.stamp.toSec(), config, times_s);
  return headed;
}

}  // namespace

CloudScan scanOfCloud(const sensor_msgs::PointCloud2& cloud,
                      const SensorMountings::Answer& mounting,
                      const core::PointCloudConfig& config) {
  const std::string& frame = cloud.header.frame_id;
  CloudScan result;
  if (!mounting.T_base_sensor) {
    result.remarks.push_back(
        {"unknown frame '" + frame + "'",
         "Point clouds of frame '" + frame + "' are refused: " + mounting.problem + "."});
    return result;
  }
  const std::string problem = layoutProblem(cloud);
  if (!problem.empty()) {
    result.remarks.push_back(
        {"point clouds that cannot be read",
         "A point cloud of frame '" + frame + "' is refused: " + problem + "."});
    return result;
  }
  const std::vector<Eigen::Vector3f> points = pointsOf(cloud, uprightFrom(mounting));
  remarkOnHeights(points, config, frame, result);
  PointTimes times = pointTimes(cloud, points, config);
  if (!times.problem.empty()) {
    result.remarks.push_back({"point clouds with senseless times of points",
                              "A point cloud of frame '" + frame +
                                  "' cannot say when its points were measured: " + times.problem +
                                  ". They are all taken as measured at its stamp."});
  }
  result.scan = std::make_shared<const HeadedScan>(
      headedScan(cloud.header, points, std::move(times.after_stamp_s), config));
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
