#include <cmath>
#include <map>

#include <GeographicLib/LocalCartesian.hpp>
#include <geometry_msgs/TransformStamped.h>
#include <gmock/gmock.h>
#include <hymm/DeadReckoning.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/NavSatFix.h>
#include <sys/wait.h>
#include <tf2_msgs/TFMessage.h>

#include "datasets/file_source.h"
#include "ros/pose_conversions.h"
#include "support/acfr_files.h"
#include "vehicle/dead_reckoning.h"

namespace hymm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr char kVehicle[] =
    "vehicle:\n"
    "  ackermann: {wheelbase_m: 2.5, encoder_offset_left_m: 0.7}\n"
    "  laser: {x_m: 3.0, y_m: -0.4, yaw_rad: 0.2}\n"
    "  gps_antenna: {x_m: 1.0, y_m: 0.25}\n"
    "  laser_frame: front_laser\n";

/// Runs the tool itself on a small recording.
class AcfrToBag : public testing::Test {
 protected:
  AcfrToBag() {
    test::writeAcfrAscii(folder_);
    folder_.write("vehicle.yaml", kVehicle);
  }

  std::filesystem::path bagPath() const { return folder_.path() / "out.bag"; }

  /// The exit code; what the tool printed goes to printed_. `before`: shell commands that set the
  /// stage.
  int run(const std::string& options, const std::string& before = "") {
    const std::filesystem::path log = folder_.path() / "log";
    const std::string command =
        before + std::string(ACFR_TO_BAG) + " " + options + " > " + log.string() + " 2>&1";
    const int status = std::system(command.c_str());
    printed_ = core::readFile(log);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::string options(const std::string& input) const {
    return "--input " + input + " --vehicle " + (folder_.path() / "vehicle.yaml").string() +
           " --output " + bagPath().string();
  }

  int convert(const std::string& more = "") {
    return run(options(folder_.path().string()) + " " + more);
  }

  void expectNoOutput() const {
    EXPECT_FALSE(std::filesystem::exists(bagPath()));
    EXPECT_FALSE(std::filesystem::exists(bagPath().string() + ".active"));
  }

  template <class Message>
  std::vector<Message> messages(const std::string& topic) const {
    rosbag::Bag bag(bagPath().string(), rosbag::bagmode::Read);
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    std::vector<Message> found;
    for (const rosbag::MessageInstance& instance : view) {
      const auto message = instance.instantiate<Message>();
      if (message != nullptr) found.push_back(*message);
    }
    return found;
  }

  test::TemporaryFolder folder_;
  std::string printed_;
};

TEST_F(AcfrToBag, BagHoldsAllTopicsWithTheirTypes) {
  ASSERT_EQ(convert(), 0) << printed_;
  rosbag::Bag bag(bagPath().string(), rosbag::bagmode::Read);
  rosbag::View view(bag);
  std::map<std::string, std::string> found;
  for (const rosbag::MessageInstance& instance : view) {
    const std::string type = instance.getDataType();
    found[instance.getTopic()] = type;
  }
  const std::map<std::string, std::string> expected = {
      {"/scan", "sensor_msgs/LaserScan"},      {"/dead_reckoning", "hymm/DeadReckoning"},
      {"/odom", "nav_msgs/Odometry"},          {"/tf", "tf2_msgs/TFMessage"},
      {"/tf_static", "tf2_msgs/TFMessage"},    {"/gps/fix", "sensor_msgs/NavSatFix"},
      {"/gps/origin", "sensor_msgs/NavSatFix"}};
  EXPECT_EQ(found, expected);
  EXPECT_FALSE(std::filesystem::exists(bagPath().string() + ".active"));
}

TEST_F(AcfrToBag, MessagesComeInTheRecordingsOrderWithItsStamps) {
  ASSERT_EQ(convert(), 0) << printed_;
  rosbag::Bag bag(bagPath().string(), rosbag::bagmode::Read);
  rosbag::View view(bag, rosbag::TopicQuery({"/scan", "/dead_reckoning", "/gps/fix"}));
  std::string order;
  ros::Time last;
  for (const rosbag::MessageInstance& instance : view) {
    order += instance.getTopic() + " ";
    EXPECT_GT(instance.getTime(), last);
    last = instance.getTime();
  }
  // The scan and the second dead-reckoning row share the stamp 0.5 s.
  EXPECT_EQ(order,
            "/gps/fix /dead_reckoning /scan /dead_reckoning /gps/fix /dead_reckoning /scan ");
  const auto motion = messages<DeadReckoning>("/dead_reckoning");
  EXPECT_EQ(motion.at(1).header.stamp, ros::Time(0, 500000000));
  EXPECT_EQ(messages<sensor_msgs::NavSatFix>("/gps/fix").at(0).header.stamp, ros::Time(0, 1));
}

TEST_F(AcfrToBag, ScanFollowsRosConventions) {
  ASSERT_EQ(convert(), 0) << printed_;
  const auto scans = messages<sensor_msgs::LaserScan>("/scan");
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].header.frame_id, "front_laser");
  EXPECT_FLOAT_EQ(scans[0].angle_min, static_cast<float>(-core::kPi / 2.0));
  EXPECT_FLOAT_EQ(scans[0].angle_max, static_cast<float>(core::kPi / 2.0));
  EXPECT_FLOAT_EQ(scans[0].range_max, 80.0f);
  EXPECT_FLOAT_EQ(scans[0].ranges.at(0), 10.0f);
  EXPECT_TRUE(std::isinf(scans[0].ranges.at(1)));
}

TEST_F(AcfrToBag, OdometryAndTfFollowTheWheelModel) {
  ASSERT_EQ(convert(), 0) << printed_;
  core::VehicleConfig vehicle;
  vehicle.ackermann = {2.5, 0.7};
  core::DeadReckoning expected(vehicle);
  expected.process(core::AckermannInput{0.4, 1.0, 0.1});
  expected.process(core::AckermannInput{0.5, 2.0, -0.1});
  expected.process(core::AckermannInput{0.6, 2.0, 0.0});
  const auto odometry = messages<nav_msgs::Odometry>("/odom");
  const auto transforms = messages<tf2_msgs::TFMessage>("/tf");
  ASSERT_EQ(odometry.size(), 3u);
  ASSERT_EQ(transforms.size(), 3u);
  const core::Pose2 pose = fromMessage(odometry[2].pose.pose);
  EXPECT_GT(pose.x_m, 0.2);
  EXPECT_LT((pose.vector() - expected.T_odom_base().vector()).norm(), 1e-12);
  EXPECT_LT((planarCovariance(odometry[2].pose) - expected.covariance()).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(odometry[2].twist.twist.linear.x, 2.0);
  // (0.02 m/s)^2 constant, (2 % of 2 m/s)^2 relative, and 0.01 rad of steering at the wheel that
  // stands 0.7 m off the centre.
  EXPECT_NEAR(odometry[2].twist.covariance[0], 4e-4 + 1.6e-3 + std::pow(2.0 * 0.7 / 2.5 * 0.01, 2),
              1e-15);
  const geometry_msgs::TransformStamped& transform = transforms[2].transforms.at(0);
  EXPECT_EQ(transform.header.frame_id, "odom");
  EXPECT_EQ(transform.child_frame_id, "base_link");
  EXPECT_LT((fromMessage(transform.transform).vector() - pose.vector()).norm(), 1e-15);
}

TEST_F(AcfrToBag, MountingsAreLatchedAtTheStart) {
  ASSERT_EQ(convert(), 0) << printed_;
  rosbag::Bag bag(bagPath().string(), rosbag::bagmode::Read);
  rosbag::View view(bag, rosbag::TopicQuery("/tf_static"));
  ASSERT_EQ(view.size(), 1u);
  EXPECT_EQ(view.begin()->getConnectionHeader()->at("latching"), "1");
  EXPECT_EQ(view.begin()->getTime(), ros::Time(0, 1));
  const auto transforms = messages<tf2_msgs::TFMessage>("/tf_static").at(0).transforms;
  ASSERT_EQ(transforms.size(), 2u);
  EXPECT_EQ(transforms[0].header.frame_id, "base_link");
  EXPECT_EQ(transforms[0].child_frame_id, "front_laser");
  EXPECT_LT(
      (fromMessage(transforms[0].transform).vector() - Eigen::Vector3d(3.0, -0.4, 0.2)).norm(),
      1e-12);
  EXPECT_EQ(transforms[1].child_frame_id, "gps");
  EXPECT_EQ(transforms[1].transform.translation.y, 0.25);
}

TEST_F(AcfrToBag, FixesLieAroundTheStatedOrigin) {
  ASSERT_EQ(convert("--gps-origin -30 150 20 --gps-deviation 0.3"), 0) << printed_;
  const auto origin = messages<sensor_msgs::NavSatFix>("/gps/origin").at(0);
  EXPECT_EQ(origin.latitude, -30.0);
  EXPECT_EQ(origin.longitude, 150.0);
  EXPECT_EQ(origin.altitude, 20.0);
  const auto fixes = messages<sensor_msgs::NavSatFix>("/gps/fix");
  ASSERT_EQ(fixes.size(), 2u);
  double east = 0.0, north = 0.0, up = 0.0;
  GeographicLib::LocalCartesian(-30.0, 150.0, 20.0)
      .Forward(fixes[0].latitude, fixes[0].longitude, fixes[0].altitude, east, north, up);
  EXPECT_NEAR(east, 4.0, 1e-6);
  EXPECT_NEAR(north, 3.0, 1e-6);
  EXPECT_LT(fixes[0].latitude - -30.0, 1e-4);
  EXPECT_GT(fixes[0].latitude, -30.0);  // north of the origin
  EXPECT_DOUBLE_EQ(fixes[0].position_covariance[0], 0.09);
}

TEST_F(AcfrToBag, FixWithoutPositionIsNoFix) {
  folder_.write("GPS.txt", "0 nan nan\n0.55 5 6\n");
  ASSERT_EQ(convert(), 0) << printed_;
  const auto fixes = messages<sensor_msgs::NavSatFix>("/gps/fix");
  EXPECT_EQ(fixes.at(0).status.status, sensor_msgs::NavSatStatus::STATUS_NO_FIX);
  EXPECT_TRUE(std::isnan(fixes.at(0).latitude));
  EXPECT_EQ(fixes.at(1).status.status, sensor_msgs::NavSatStatus::STATUS_FIX);
}

TEST_F(AcfrToBag, SummaryTellsCountsAndWhatWasSkipped) {
  ASSERT_EQ(convert(), 0);
  EXPECT_THAT(printed_, AllOf(HasSubstr("2 scans, 3 dead-reckoning inputs, 2 GPS fixes"),
                              HasSubstr("0.000 s to 0.700 s"),
                              HasSubstr("1 GPS events whose row is missing, skipped")));
}

TEST_F(AcfrToBag, TakesMatlabFilesTogether) {
  const auto path = [&](const char* name) { return (folder_.path() / name).string(); };
  test::writeMatFile(path("a.mat"),
                     {test::matRow("TLsr", {500.0}), test::matScans("LASER", {700.0}, true)});
  test::writeMatFile(path("b.mat"), {test::matRow("time", {400.0}), test::matRow("speed", {1.0}),
                                     test::matRow("steering", {0.0})});
  ASSERT_EQ(run(options(path("a.mat") + " " + path("b.mat"))), 0) << printed_;
  EXPECT_EQ(messages<sensor_msgs::LaserScan>("/scan").size(), 1u);
  EXPECT_TRUE(messages<sensor_msgs::NavSatFix>("/gps/origin").empty());
}

TEST_F(AcfrToBag, BadRecordingLeavesNoBag) {
  folder_.write("LASER.txt", "0.5\tten\t");
  EXPECT_EQ(convert(), 1);
  EXPECT_THAT(printed_, AllOf(HasSubstr("acfr_to_bag: "), HasSubstr("'ten' is not a number")));
  expectNoOutput();
}

TEST_F(AcfrToBag, FullDiskIsToldAndLeavesNoBag) {
  // Enough scans for several chunks of the bag, and room for less.
  std::string scans, order;
  for (int i = 0; i < 3000; ++i) {
    scans += test::acfrScanText(std::to_string(1 + i), static_cast<std::size_t>(i % 361),
                                std::to_string(i % 79));
    order += std::to_string(1 + i) + " 3 " + std::to_string(1 + i) + "\n";
  }
  folder_.write("LASER.txt", scans);
  folder_.write("Sensors_manager.txt", order);
  for (const char* blocks : {"4", "40"}) {
    EXPECT_EQ(run(options(folder_.path().string()),
                  std::string("trap '' XFSZ; ulimit -f ") + blocks + "; "),
              1);
    EXPECT_THAT(printed_, HasSubstr("out.bag cannot be written"));
    expectNoOutput();
  }
}

TEST_F(AcfrToBag, FailureKeepsAnOlderBag) {
  folder_.write("out.bag", "older");
  folder_.write("LASER.txt", "0.5\tten\t");
  EXPECT_EQ(convert(), 1);
  EXPECT_EQ(core::readFile(bagPath()), "older");
}

TEST_F(AcfrToBag, BadVehicleLeavesNoBag) {
  folder_.write("vehicle.yaml", "vehicle: {ackermann: {wheelbase_m: -1}}\n");
  EXPECT_EQ(convert(), 1);
  EXPECT_THAT(printed_, HasSubstr("wheelbase_m"));
  expectNoOutput();
}

TEST_F(AcfrToBag, RefusesOutputInMissingFolder) {
  EXPECT_EQ(run("--input " + folder_.path().string() + " --vehicle " +
                (folder_.path() / "vehicle.yaml").string() + " --output " +
                (folder_.path() / "none" / "out.bag").string()),
            1);
  EXPECT_THAT(printed_, HasSubstr("does not exist; make it"));
}

TEST_F(AcfrToBag, RefusesImpossibleGpsOrigin) {
  EXPECT_EQ(convert("--gps-origin 100 0 0"), 1);
  EXPECT_THAT(printed_, HasSubstr("the latitude must be between -90 and 90"));
  expectNoOutput();
}

TEST_F(AcfrToBag, HelpNamesAllOptionsAndMissingOnesAreTold) {
  EXPECT_EQ(run("--help"), 0);
  EXPECT_THAT(printed_, AllOf(HasSubstr("--input"), HasSubstr("--vehicle"), HasSubstr("--output"),
                              HasSubstr("--gps-origin"), HasSubstr("--gps-deviation")));
  EXPECT_NE(run("--output x.bag"), 0);
  EXPECT_THAT(printed_, HasSubstr("--input is required"));
}

}  // namespace
}  // namespace hymm
