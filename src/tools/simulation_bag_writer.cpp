#include "tools/simulation_bag_writer.h"

#include <algorithm>

#include <geometry_msgs/PoseStamped.h>
#include <hymm/LandmarkMap.h>
#include <hymm/PropertySample.h>
#include <nav_msgs/OccupancyGrid.h>

#include "ros/pose_conversions.h"
#include "ros/sensor_conversions.h"
#include "tools/latched_message.h"

namespace hymm {
namespace {

constexpr char kWriter[] = "simulate_world";
constexpr char kMapFrame[] = "map";
constexpr std::int8_t kOccupied = 100, kFree = 0;

}  // namespace

SimulationBagWriter::SimulationBagWriter(rosbag::Bag& bag, const core::SimulationConfig& config,
                                         const core::VehicleConfig& vehicle,
                                         const core::Terrain& terrain)
    : bag_(bag),
      vehicle_(vehicle),
      altimeter_(config.altimeter),
      terrain_(terrain),
      vehicle_bag_(bag, vehicle,
                   {config.gps.origin_latitude_deg, config.gps.origin_longitude_deg,
                    config.gps.origin_altitude_m},
                   kWriter) {}

void SimulationBagWriter::writeLandmarks(const std::vector<core::TrueLandmark>& landmarks,
                                         double time_s) {
  LandmarkMap map;
  map.header.stamp = ros::Time(time_s);
  map.header.frame_id = kMapFrame;
  for (const core::TrueLandmark& landmark : landmarks) {
    Landmark message;  // known exactly: all covariances are 0
    message.id = landmark.id;
    message.type = static_cast<std::uint8_t>(landmark.type);
    message.position.x = landmark.position.x();
    message.position.y = landmark.position.y();
    message.position.z = terrain_.height(landmark.position);
    message.diameter = landmark.diameter_m;
    message.last_seen = map.header.stamp;
    map.landmarks.push_back(message);
  }
  writeLatched(bag_, "/truth/landmarks", map.header.stamp, map, kWriter);
}

void SimulationBagWriter::writeOccupancy(const core::TrueOccupancy& occupancy, double time_s) {
  nav_msgs::OccupancyGrid grid;
  grid.header.stamp = ros::Time(time_s);
  grid.header.frame_id = kMapFrame;
  grid.info.map_load_time = grid.header.stamp;
  grid.info.resolution = static_cast<float>(occupancy.resolution_m);
  grid.info.width = static_cast<std::uint32_t>(occupancy.width);
  grid.info.height = static_cast<std::uint32_t>(occupancy.height);
  grid.info.origin = toPoseMessage({occupancy.origin.x(), occupancy.origin.y(), 0.0});
  grid.data.resize(occupancy.occupied.size());
  std::transform(occupancy.occupied.begin(), occupancy.occupied.end(), grid.data.begin(),
                 [](bool occupied) { return occupied ? kOccupied : kFree; });
  writeLatched(bag_, "/truth/map", grid.header.stamp, grid, kWriter);
}

void SimulationBagWriter::write(const core::SimulatedEvent& simulated) {
  std::visit([this](const auto& event) { write(event); }, simulated.event);
  const bool is_scan = std::holds_alternative<core::ScanEvent>(simulated.event);
  const bool is_detection = std::holds_alternative<core::ObservationSet>(simulated.event);
  const double time_s = core::timeOf(simulated.event);
  if (is_scan || is_detection) writePose(simulated.T_map_base, time_s);
  if (simulated.height_m) writeHeight(*simulated.height_m, time_s);
}

void SimulationBagWriter::write(const core::MotionInput& input) {
  const ros::Time stamp(core::timeOf(input));
  if (const auto* encoders = std::get_if<core::AckermannInput>(&input)) {
    bag_.write("/dead_reckoning", stamp, toMessage(*encoders, vehicle_.base_frame));
  }
  vehicle_bag_.writeOdometry(input, stamp);
}

void SimulationBagWriter::write(const core::ScanEvent& event) {
  bag_.write("/scan", ros::Time(event.scan.time_s), toMessage(event.scan, vehicle_.laser_frame));
}

void SimulationBagWriter::write(const core::ObservationSet& set) {
  bag_.write("/detections", ros::Time(set.time_s), toMessage(set, vehicle_.laser_frame));
}

void SimulationBagWriter::write(const core::GpsFix& fix) {
  sensor_msgs::NavSatFix message =
      vehicle_bag_.fixAt(ros::Time(fix.time_s), fix.position.x(), fix.position.y());
  message.position_covariance[0] = fix.covariance(0, 0);
  message.position_covariance[1] = message.position_covariance[3] = fix.covariance(0, 1);
  message.position_covariance[4] = fix.covariance(1, 1);
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_KNOWN;
  bag_.write("/gps/fix", message.header.stamp, message);
}

void SimulationBagWriter::writePose(const core::Pose2& T_map_base, double time_s) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = ros::Time(time_s);
  message.header.frame_id = kMapFrame;
  message.pose = toPoseMessage(T_map_base);
  if (!terrain_.isLevel()) {
    const Eigen::Isometry3d T = terrain_.standing(T_map_base);
    const Eigen::Quaterniond q(T.linear());
    message.pose.position.z = T.translation().z();
    message.pose.orientation.w = q.w();
    message.pose.orientation.x = q.x();
    message.pose.orientation.y = q.y();
    message.pose.orientation.z = q.z();
  }
  bag_.write("/truth/pose", message.header.stamp, message);
}

void SimulationBagWriter::writeHeight(double height_m, double time_s) {
  PropertySample message;  // at base_link
  message.header.stamp = ros::Time(time_s);
  message.header.frame_id = vehicle_.base_frame;
  message.layer = altimeter_.layer;
  message.position_covariance[0] = message.position_covariance[3] =
      altimeter_.place_deviation_m * altimeter_.place_deviation_m;
  message.value = height_m;
  message.variance = altimeter_.deviation_m * altimeter_.deviation_m;
  bag_.write("/property_samples", message.header.stamp, message);
}

}  // namespace hymm
