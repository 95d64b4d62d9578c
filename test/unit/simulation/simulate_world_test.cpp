#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <GeographicLib/LocalCartesian.hpp>
#include <geometry_msgs/PoseStamped.h>
#include <gmock/gmock.h>
#include <hymm/DeadReckoning.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkObservations.h>
#include <hymm/PropertySample.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/NavSatFix.h>
#include <sys/wait.h>
#include <tf2_msgs/TFMessage.h>

#include "datasets/file_source.h"
#include "ros/pose_conversions.h"
#include "ros/sensor_conversions.h"
#include "simulation/simulation.h"
#include "support/temporary_folder.h"

namespace hymm {
namespace {

using testing::HasSubstr;

/// Runs the tool itself.
class SimulateWorld : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }

  /// The exit code; what the tool printed goes to printed_.
  int run(const std::string& options) {
    const std::string command =
        std::string(SIMULATE_WORLD) + " " + options + " > " + file("log").string() + " 2>&1";
    const int status = std::system(command.c_str());
    printed_ = core::readFile(file("log"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  int simulate(const std::string& options, const std::string& bag = "out.bag") {
    return run(options + " --output " + file(bag).string());
  }

  template <class Message>
  std::vector<Message> messages(const std::string& topic) const {
    rosbag::Bag bag(file("out.bag").string(), rosbag::bagmode::Read);
    std::vector<Message> found;
    for (const rosbag::MessageInstance& instance : rosbag::View(bag, rosbag::TopicQuery(topic))) {
      if (const auto message = instance.instantiate<Message>()) found.push_back(*message);
    }
    return found;
  }

  test::TemporaryFolder folder_;
  std::string printed_;
};

TEST_F(SimulateWorld, WritesWhatTheSimulationYields) {
  ASSERT_EQ(simulate("--world car_park --seed 7 --duration 10"), 0) << printed_;
  core::SimulationConfig config;
  config.world.name = "car_park";
  config.drive.duration_s = 10.0;
  core::Simulation simulation(config, core::simulatedCar(), 7);
  const auto scans = messages<sensor_msgs::LaserScan>("/scan");
  const auto poses = messages<geometry_msgs::PoseStamped>("/truth/pose");
  const auto motion = messages<DeadReckoning>("/dead_reckoning");
  std::size_t scan = 0, input = 0;
  while (const auto simulated = simulation.next()) {
    if (const auto* event = std::get_if<core::ScanEvent>(&simulated->event)) {
      ASSERT_LT(scan, scans.size());
      EXPECT_EQ(scans[scan].ranges, event->scan.ranges_m);
      EXPECT_EQ(scans[scan].intensities, event->scan.intensities);
      EXPECT_EQ(scans[scan].header.frame_id, "laser");
      EXPECT_EQ(poses[scan].header.stamp, scans[scan].header.stamp);
      EXPECT_EQ(poses[scan].header.frame_id, "map");
      const core::Pose2 error = inverse(fromMessage(poses[scan].pose)) * simulated->T_map_base;
      EXPECT_LT(error.vector().norm(), 1e-9);
      ++scan;
    } else if (const auto* moved = std::get_if<core::MotionInput>(&simulated->event)) {
      ASSERT_LT(input, motion.size());
      EXPECT_EQ(motion[input].speed, std::get<core::AckermannInput>(*moved).speed_mps);
      EXPECT_EQ(motion[input].steering, std::get<core::AckermannInput>(*moved).steering_rad);
      ++input;
    }
  }
  EXPECT_EQ(scan, scans.size());
  EXPECT_EQ(scan, 50U);
  EXPECT_EQ(input, motion.size());
}

TEST_F(SimulateWorld, WritesTheTruthInTheMapFrame) {
  ASSERT_EQ(simulate("--world park --landmarks 60 --duration 2"), 0) << printed_;
  const auto maps = messages<LandmarkMap>("/truth/landmarks");
  const auto grids = messages<nav_msgs::OccupancyGrid>("/truth/map");
  ASSERT_EQ(maps.size(), 1U);
  ASSERT_EQ(grids.size(), 1U);
  EXPECT_EQ(maps[0].header.frame_id, "map");
  ASSERT_EQ(maps[0].landmarks.size(), 60U);
  const auto& grid = grids[0];
  ASSERT_EQ(grid.data.size(), grid.info.width * grid.info.height);
  for (const Landmark& landmark : maps[0].landmarks) {
    EXPECT_EQ(landmark.type, LandmarkObservation::TYPE_TRUNK);
    const double resolution = static_cast<double>(grid.info.resolution);
    const auto x =
        static_cast<std::size_t>((landmark.position.x - grid.info.origin.position.x) / resolution);
    const auto y =
        static_cast<std::size_t>((landmark.position.y - grid.info.origin.position.y) / resolution);
    EXPECT_EQ(grid.data[y * grid.info.width + x], 100);
  }
}

TEST_F(SimulateWorld, TellsHeightsInSpaceWhereThereAreHills) {
  ASSERT_EQ(simulate("--world hills --duration 20"), 0) << printed_;
  const auto poses = messages<geometry_msgs::PoseStamped>("/truth/pose");
  const auto samples = messages<PropertySample>("/property_samples");
  ASSERT_EQ(samples.size(), poses.size());
  double highest = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].layer, "height");
    EXPECT_EQ(samples[i].header.frame_id, "base_link");
    EXPECT_EQ(samples[i].header.stamp, poses[i].header.stamp);
    EXPECT_NEAR(samples[i].value, poses[i].pose.position.z, 0.3);  // six deviations
    highest = std::max(highest, std::abs(poses[i].pose.position.z));
  }
  EXPECT_GT(highest, 0.1);
  ASSERT_EQ(simulate("--world park --duration 2"), 0) << printed_;
  EXPECT_TRUE(messages<PropertySample>("/property_samples").empty());
}

TEST_F(SimulateWorld, MountsTheSensorsOfTheGivenVehicle) {
  folder_.write("robot.yaml",
                "vehicle:\n"
                "  ackermann: {wheelbase_m: 1.2}\n"
                "  laser: {x_m: 0.4, y_m: -0.1, yaw_rad: 0.3}\n"
                "  laser_frame: front_laser\n");
  ASSERT_EQ(simulate("--duration 2 --vehicle " + file("robot.yaml").string()), 0) << printed_;
  const auto mountings = messages<tf2_msgs::TFMessage>("/tf_static");
  ASSERT_EQ(mountings.size(), 1U);
  const auto& laser = mountings[0].transforms[0];
  EXPECT_EQ(laser.header.frame_id, "base_link");
  EXPECT_EQ(laser.child_frame_id, "front_laser");
  EXPECT_DOUBLE_EQ(laser.transform.translation.x, 0.4);
  EXPECT_DOUBLE_EQ(laser.transform.translation.y, -0.1);
  EXPECT_NEAR(yawOf(laser.transform.rotation), 0.3, 1e-12);
  EXPECT_EQ(messages<sensor_msgs::LaserScan>("/scan").front().header.frame_id, "front_laser");
}

TEST_F(SimulateWorld, PlacesFixesAroundTheStatedOrigin) {
  ASSERT_EQ(simulate("--duration 5"), 0) << printed_;
  const auto origins = messages<sensor_msgs::NavSatFix>("/gps/origin");
  const auto fixes = messages<sensor_msgs::NavSatFix>("/gps/fix");
  ASSERT_EQ(origins.size(), 1U);
  ASSERT_FALSE(fixes.empty());
  const GeographicLib::LocalCartesian local(origins[0].latitude, origins[0].longitude,
                                            origins[0].altitude);
  core::Simulation simulation({}, core::simulatedCar(), 1);
  while (const auto simulated = simulation.next()) {
    const auto* fix = std::get_if<core::GpsFix>(&simulated->event);
    if (fix == nullptr) continue;
    double east = 0.0, north = 0.0, up = 0.0;
    local.Forward(fixes[0].latitude, fixes[0].longitude, fixes[0].altitude, east, north, up);
    EXPECT_NEAR(east, fix->position.x(), 1e-6);
    EXPECT_NEAR(north, fix->position.y(), 1e-6);
    EXPECT_DOUBLE_EQ(fixes[0].position_covariance[0], fix->covariance(0, 0));
    break;
  }
}

TEST_F(SimulateWorld, GivesTheSameBytesForTheSameSeed) {
  ASSERT_EQ(simulate("--world car_park --duration 5 --seed 3", "a.bag"), 0) << printed_;
  ASSERT_EQ(simulate("--world car_park --duration 5 --seed 3", "b.bag"), 0) << printed_;
  ASSERT_EQ(simulate("--world car_park --duration 5 --seed 4", "c.bag"), 0) << printed_;
  const std::string a = core::readFile(file("a.bag"));
  EXPECT_TRUE(a == core::readFile(file("b.bag")));
  EXPECT_FALSE(a == core::readFile(file("c.bag")));
}

TEST_F(SimulateWorld, RefusesDurationsThatAreNoNumberAboveZero) {
  for (const std::string duration : {"nan", "inf", "0", "-1", "long"}) {
    EXPECT_NE(simulate("--duration " + duration), 0) << duration;
    EXPECT_THAT(printed_, HasSubstr("'" + duration + "' is no number above 0"));
    EXPECT_FALSE(std::filesystem::exists(file("out.bag")));
  }
}

TEST_F(SimulateWorld, ServesRobotsWithOnlyOdometry) {
  ASSERT_EQ(simulate("--duration 3 --motion odom"), 0) << printed_;  // 40 Hz, both ends included
  EXPECT_TRUE(messages<DeadReckoning>("/dead_reckoning").empty());
  EXPECT_EQ(messages<nav_msgs::Odometry>("/odom").size(), 121U);
  EXPECT_EQ(messages<tf2_msgs::TFMessage>("/tf").size(), 121U);
}

TEST_F(SimulateWorld, ServesRobotsWithTheirOwnDetector) {
  ASSERT_EQ(simulate("--duration 3 --detections"), 0) << printed_;
  EXPECT_TRUE(messages<sensor_msgs::LaserScan>("/scan").empty());
  const auto sets = messages<LandmarkObservations>("/detections");
  ASSERT_EQ(sets.size(), 15U);
  EXPECT_EQ(messages<geometry_msgs::PoseStamped>("/truth/pose").size(), sets.size());
  for (const LandmarkObservations& set : sets) {
    for (const auto& observation : set.observations) EXPECT_EQ(observation.identity, -1);
  }
}

TEST_F(SimulateWorld, ListsItsWorlds) {
  ASSERT_EQ(run("--list"), 0);
  for (const char* world : {"park", "car_park", "plain"}) EXPECT_THAT(printed_, HasSubstr(world));
}

TEST_F(SimulateWorld, SaysWhatIsWrongAndWritesNothing) {
  EXPECT_EQ(simulate("--world car_pork"), 1);
  EXPECT_THAT(printed_, HasSubstr("did you mean 'car_park'?"));
  EXPECT_EQ(simulate("--vehicle " + file("none.yaml").string()), 1);
  EXPECT_THAT(printed_, HasSubstr("none.yaml"));
  folder_.write("bad.yaml", "simulation: {laser: {beams: 1, rate_hz: -3}}\n");
  EXPECT_EQ(simulate("--config " + file("bad.yaml").string()), 1);
  EXPECT_THAT(printed_, HasSubstr("beams"));
  EXPECT_THAT(printed_, HasSubstr("rate_hz"));
  folder_.write("other.yaml", "laser: {beams: 181}\n");
  EXPECT_EQ(simulate("--config " + file("other.yaml").string()), 1);
  EXPECT_THAT(printed_, HasSubstr("no group 'simulation'"));
  EXPECT_EQ(run("--world park"), 1);
  EXPECT_THAT(printed_, HasSubstr("--output"));
  EXPECT_EQ(simulate("--world park", "no/such/folder.bag"), 1);
  EXPECT_FALSE(std::filesystem::exists(file("out.bag")));
  EXPECT_FALSE(std::filesystem::exists(file("out.bag.active")));
}

TEST_F(SimulateWorld, RefusesAPlainTooSmallToDrive) {
  EXPECT_EQ(simulate("--world plain --landmarks 5"), 1);
  EXPECT_THAT(printed_, HasSubstr("at least 20"));
}

}  // namespace
}  // namespace hymm
