#include "ros/cloud_conversions.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <vector>

#include <boost/make_shared.hpp>

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

const sensor_msgs::PointField* findField(const sensor_msgs::PointCloud2& cloud,
                                         const std::string& name) {
  const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  return field == cloud.fields.end() ? nullptr : &*field;
}

std::size_t sizeOf(const sensor_msgs::PointField& field) {
  return field.datatype == sensor_msgs::PointField::FLOAT64 ? sizeof(double) : sizeof(float);
}

/// Why a coordinate cannot be read; empty if it can.
std::string fieldProblem(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  const sensor_msgs::PointField* field = findField(cloud, name);
  if (field == nullptr) return "it has no field '" + name + "'; it has " + listOf(cloud.fields);
  const bool is_float = field->datatype == sensor_msgs::PointField::FLOAT32 ||
                        field->datatype == sensor_msgs::PointField::FLOAT64;
  if (!is_float || field->count > 1U) {
    return "its field '" + name + "' is not one FLOAT32 or FLOAT64";
  }
  if (std::size_t{field->offset} + sizeOf(*field) > cloud.point_step) {
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

/// One coordinate of the points of a cloud whose layout was checked.
class Coordinate {
 public:
  Coordinate(const sensor_msgs::PointCloud2& cloud, const std::string& name)
      : offset_(findField(cloud, name)->offset),
        size_(sizeOf(*findField(cloud, name))),
        swaps_(cloud.is_bigendian != 0U) {}

  float of(const std::uint8_t* point) const {
    std::array<std::uint8_t, sizeof(double)> bytes{};
    std::copy_n(point + offset_, size_, bytes.begin());
    if (swaps_) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size_));
    if (size_ == sizeof(double)) {
      double value = 0.0;
      std::memcpy(&value, bytes.data(), sizeof(value));
      return static_cast<float>(value);
    }
    float value = 0.0F;
    std::memcpy(&value, bytes.data(), sizeof(value));
    return value;
  }

 private:
  std::size_t offset_, size_;
  bool swaps_;
};

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
  const Coordinate x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data.data() + row * cloud.row_step;
    for (std::size_t i = 0; i < cloud.width; ++i, point += cloud.point_step) {
      points.emplace_back(T_upright_cloud * Eigen::Vector3f(x.of(point), y.of(point), z.of(point)));
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
  result.cause = "point clouds without a point at the heights of obstacles";
  result.problem = sentence.str();
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
  const std::vector<Eigen::Vector3f> points = pointsOf(cloud, uprightFrom(mounting));
  remarkOnHeights(points, config, frame, result);
  const auto scan = boost::make_shared<sensor_msgs::LaserScan>(
      toMessage(core::scanOfPoints(points, cloud.header.stamp.toSec(), config), frame));
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
