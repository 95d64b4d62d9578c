#include "ros/cloud_scans.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <boost/make_shared.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "perception/scan_check.h"
#include "ros/event_reader.h"

namespace hymm {
namespace {

using testing::Contains;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Key;
using testing::Not;
using testing::SizeIs;

constexpr double kWait_s = 5.0;

boost::shared_ptr<sensor_msgs::PointCloud2> cloudOf(const std::vector<Eigen::Vector3f>& points) {
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header.frame_id = "lidar";
  cloud->header.stamp = ros::Time(12.25);
  sensor_msgs::PointCloud2Modifier modifier(*cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(points.size());
  if (points.empty()) return cloud;  // of nothing ROS's iterators compute addresses all the same
  sensor_msgs::PointCloud2Iterator<float> x(*cloud, "x"), y(*cloud, "y"), z(*cloud, "z");
  for (const Eigen::Vector3f& point : points) {
    *x = point.x(), *y = point.y(), *z = point.z();
    ++x, ++y, ++z;
  }
  return cloud;
}

class PointClouds : public testing::Test {
 protected:
  /// The lidar stands 2 m ahead of and 1.5 m above base_link, turned left and its nose down.
  void mount(double yaw_rad = 0.0, double pitch_rad = 0.0) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()));
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "lidar";
    transform.transform.translation.x = 2.0;
    transform.transform.translation.z = 1.5;
    transform.transform.rotation.x = q.x();
    transform.transform.rotation.y = q.y();
    transform.transform.rotation.z = q.z();
    transform.transform.rotation.w = q.w();
    tf_.setTransform(transform, "test", true);
  }
  SensorMountings mountings() { return SensorMountings(tf_, "base_link", std::nullopt, kWait_s); }

  std::string problemOf(const sensor_msgs::PointCloud2& cloud) {
    const auto remarks =
        scanOfCloud(cloud, mountings().findInSpace("lidar", 0.0), core::PointCloudConfig()).remarks;
    return remarks.empty() ? "" : remarks.front().problem;
  }

  tf2::BufferCore tf_;
  CauseLog causes_;
  CloudScans scans_{mountings(), core::PointCloudConfig(), causes_};
};

TEST_F(PointClouds, BecomeScansOfTheirStamp) {
  mount();
  scans_.add(cloudOf({{5.0F, 0.0F, -0.5F}, {3.0F, 0.0F, -1.5F}}));
  const auto scans = scans_.takeReady(0.0);
  ASSERT_THAT(scans, SizeIs(1));
  EXPECT_EQ(scans[0]->header.stamp, ros::Time(12.25));
  EXPECT_EQ(scans[0]->header.frame_id, "lidar");
  EXPECT_THAT(scans[0]->scan.ranges_m, Contains(FloatNear(5.0F, 1e-5F)));
  EXPECT_THAT(scans[0]->scan.ranges_m, Not(Contains(FloatNear(3.0F, 0.1F))));  // the ground
}

TEST_F(PointClouds, OfATiltedSensorAreRightedByTf) {
  mount(0.4, 0.3);
  // 6 m along the sensor's heading and 1 m above base_link, in the sensor's axes.
  const Eigen::Vector3f point =
      (Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()) * Eigen::Vector3d(6.0, 0.0, -0.5))
          .cast<float>();
  const auto cloud = cloudOf({point});
  EventReader reader(mountings(), GpsConverter({0.0, 0.0}), core::PointCloudConfig(), true,
                     causes_);
  const auto event =
      reader.read(SensorMessage(sensor_msgs::PointCloud2::ConstPtr(cloud)), 0.0).event;
  ASSERT_TRUE(event);
  const auto& scan = std::get<core::ScanEvent>(*event);
  EXPECT_NEAR(scan.T_base_laser.x_m, 2.0, 1e-9);
  EXPECT_NEAR(scan.T_base_laser.yaw_rad, 0.4, 1e-9);
  EXPECT_EQ(scan.scan.time_s, 12.25);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < scan.scan.ranges_m.size(); ++i) {
    if (!std::isfinite(scan.scan.ranges_m[i])) continue;
    ++seen;
    EXPECT_NEAR(scan.scan.ranges_m[i], 6.0F, 1e-4F);
    EXPECT_NEAR(scan.scan.bearing(i), 0.0, scan.scan.angle_increment_rad);
  }
  EXPECT_EQ(seen, 1U);
}

TEST_F(PointClouds, WithoutTheFieldsNeededAreRefusedAndCounted) {
  mount();
  const auto cloud = cloudOf({{5.0F, 0.0F, 0.0F}});
  cloud->fields[2].name = "height";
  scans_.add(cloud);
  EXPECT_THAT(scans_.takeReady(0.0), IsEmpty());
  EXPECT_THAT(causes_.counts(), Contains(Key("point clouds that cannot be read")));
  EXPECT_THAT(problemOf(*cloud), HasSubstr("no field 'z'; it has x, y, height"));
  cloud->fields.clear();
  EXPECT_THAT(problemOf(*cloud), HasSubstr("no field 'x'; it has none"));
}

TEST_F(PointClouds, WhoseDataDoNotFitTheirLayoutAreRefused) {
  mount();
  const auto whole = cloudOf({{5.0F, 0.0F, 0.0F}, {6.0F, 0.0F, 0.0F}});
  EXPECT_EQ(problemOf(*whole), "");
  sensor_msgs::PointCloud2 cloud = *whole;
  cloud.data.pop_back();
  EXPECT_THAT(problemOf(cloud), HasSubstr("size"));
  cloud = *whole;
  cloud.width = std::numeric_limits<std::uint32_t>::max();
  EXPECT_THAT(problemOf(cloud), HasSubstr("size"));
  cloud = *whole;
  cloud.fields[0].datatype = sensor_msgs::PointField::INT32;
  EXPECT_THAT(problemOf(cloud), HasSubstr("FLOAT32"));
  cloud = *whole;
  cloud.row_step = 4U;
  EXPECT_THAT(problemOf(cloud), HasSubstr("size"));
  cloud = *whole;
  cloud.fields[0].offset = std::numeric_limits<std::uint32_t>::max();
  EXPECT_THAT(problemOf(cloud), HasSubstr("point_step"));
}

TEST_F(PointClouds, OfDoublesInBigEndianRowsWithPaddingAreRead) {
  mount();
  constexpr std::uint32_t kPadding = 12;
  sensor_msgs::PointCloud2 cloud = *cloudOf({});
  cloud.height = 2U;
  cloud.width = 1U;
  cloud.point_step = 3U * sizeof(double);
  cloud.row_step = cloud.point_step + kPadding;
  cloud.is_bigendian = 1U;
  cloud.fields.resize(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    cloud.fields[i].datatype = sensor_msgs::PointField::FLOAT64;
    cloud.fields[i].offset = i * static_cast<std::uint32_t>(sizeof(double));
  }
  cloud.data.assign(2U * cloud.row_step - kPadding, 0U);  // the last row ends with its points
  const auto put = [&](std::size_t at, double value) {
    std::uint8_t bytes[sizeof(double)];
    std::memcpy(bytes, &value, sizeof(value));
    std::reverse_copy(bytes, bytes + sizeof(double), cloud.data.begin() + static_cast<long>(at));
  };
  put(0, 6.0);                                // x of the first row's point
  put(cloud.row_step + sizeof(double), 5.0);  // y of the second's
  EXPECT_EQ(problemOf(cloud), "");
  scans_.add(boost::make_shared<sensor_msgs::PointCloud2>(cloud));
  const auto scans = scans_.takeReady(0.0);
  ASSERT_THAT(scans, SizeIs(1));
  EXPECT_EQ(std::count_if(scans[0]->scan.ranges_m.begin(), scans[0]->scan.ranges_m.end(),
                          [](float range) { return range == 6.0F || range == 5.0F; }),
            2);
}

/// A cloud with a point on the left, measured first, and one on the right, whose field of times
/// holds `first` and `last`.
template <class Number>
boost::shared_ptr<sensor_msgs::PointCloud2> timedCloud(const std::string& name,
                                                       std::uint8_t datatype, Number first,
                                                       Number last, bool big_endian = false) {
  auto cloud = cloudOf({});
  cloud->fields.resize(4);
  cloud->fields[3].name = name;
  cloud->fields[3].datatype = datatype;
  cloud->fields[3].count = 1U;
  cloud->fields[3].offset = 3U * sizeof(float);
  cloud->point_step = 3U * sizeof(float) + sizeof(Number);
  cloud->width = 2U;
  cloud->row_step = 2U * cloud->point_step;
  cloud->is_bigendian = big_endian ? 1U : 0U;
  cloud->data.clear();
  const auto put = [&](auto value) {
    std::uint8_t bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    if (big_endian) std::reverse(bytes, bytes + sizeof(value));
    cloud->data.insert(cloud->data.end(), bytes, bytes + sizeof(value));
  };
  for (const float y : {5.0F, -5.0F}) {
    for (const float value : {0.0F, y, -0.5F}) put(value);
    put(y > 0.0F ? first : last);
  }
  return cloud;
}

/// When the beams that met the two points were measured, by the clock of the stamp.
std::array<double, 2> timesOf(const HeadedScan& scan) {
  std::array<double, 2> times{};
  for (std::size_t i = 0; i < scan.scan.ranges_m.size(); ++i) {
    if (!std::isfinite(scan.scan.ranges_m[i])) continue;
    times[std::sin(scan.scan.bearing(i)) > 0.0 ? 0 : 1] =
        scan.scan.time_s + scan.scan.beamTime_s(i);
  }
  return times;
}

TEST_F(PointClouds, TellWhenTheirPointsWereMeasuredAsTheirDriversDo) {
  using Field = sensor_msgs::PointField;
  mount();
  const std::vector<sensor_msgs::PointCloud2::ConstPtr> clouds = {
      timedCloud<float>("time", Field::FLOAT32, 0.02F, 0.09F),
      timedCloud<float>("time", Field::FLOAT32, 0.02F, 0.09F, true),
      timedCloud<std::uint32_t>("t", Field::UINT32, 20000000U, 90000000U),
      timedCloud<std::uint32_t>("offset_time", Field::UINT32, 20000000U, 90000000U),
      timedCloud<double>("timestamp", Field::FLOAT64, 12.27, 12.34),
      timedCloud<double>("timestamp", Field::FLOAT64, 12.27e9, 12.34e9),
      timedCloud<double>("time", Field::FLOAT64, 0.02, 0.09)};
  for (const auto& cloud : clouds) {
    SCOPED_TRACE(cloud->fields[3].name);
    scans_.add(cloud);
    const auto scans = scans_.takeReady(0.0);
    ASSERT_THAT(scans, SizeIs(1));
    EXPECT_EQ(scans[0]->header.stamp, ros::Time(12.25));
    EXPECT_EQ(scanProblem(scans[0]->scan), std::nullopt);
    ASSERT_FALSE(scans[0]->scan.beam_times_s.empty());
    EXPECT_NEAR(timesOf(*scans[0])[0], 12.27, 1e-6);
    EXPECT_NEAR(timesOf(*scans[0])[1], 12.34, 1e-6);
  }
  EXPECT_EQ(causes_.total(), 0U);
}

TEST_F(PointClouds, StampedAtTheirLastPointAreScansOfTheirFirst) {
  // velodyne_pointcloud does so unless timestamp_first_packet says otherwise.
  mount();
  const auto cloud = timedCloud<float>("time", sensor_msgs::PointField::FLOAT32, -0.09F, -0.01F);
  scans_.add(cloud);
  const auto scans = scans_.takeReady(0.0);
  ASSERT_THAT(scans, SizeIs(1));
  EXPECT_NEAR(scans[0]->header.stamp.toSec(), 12.16, 1e-6);
  EXPECT_EQ(scans[0]->header.stamp.toSec(), scans[0]->scan.time_s);
  EXPECT_EQ(scans[0]->told_stamp, ros::Time(12.25));
  EXPECT_NEAR(timesOf(*scans[0])[0], 12.16, 1e-6);
  EXPECT_NEAR(timesOf(*scans[0])[1], 12.24, 1e-6);

  EventReader unbelieving(mountings(), GpsConverter({0.0, 0.0}), core::PointCloudConfig(), false,
                          causes_);
  const auto event =
      unbelieving.read(SensorMessage(sensor_msgs::PointCloud2::ConstPtr(cloud)), 0.0).event;
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<core::ScanEvent>(*event).scan.time_s, 12.25);
  EXPECT_EQ(std::get<core::ScanEvent>(*event).scan.sweep_s(), 0.0);
}

TEST_F(PointClouds, WithSenselessTimesCountAsMeasuredAtTheirStamp) {
  using Field = sensor_msgs::PointField;
  mount();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<sensor_msgs::PointCloud2::ConstPtr> clouds = {
      timedCloud<float>("time", Field::FLOAT32, 0.0F, 100.0F),  // milliseconds
      timedCloud<float>("time", Field::FLOAT32, nan, 0.1F),
      timedCloud<double>("timestamp", Field::FLOAT64, 1.7e9, 1.7e9),  // another clock
      timedCloud<std::uint32_t>("t", Field::UINT32, 0U, 4000000000U),
      timedCloud<std::uint32_t>("t", Field::UINT8, 0U, 1U)};
  for (const auto& cloud : clouds) {
    scans_.add(cloud);
    const auto scans = scans_.takeReady(0.0);
    ASSERT_THAT(scans, SizeIs(1));
    EXPECT_EQ(scans[0]->scan.time_s, 12.25);
    EXPECT_EQ(scans[0]->scan.sweep_s(), 0.0);
  }
  EXPECT_EQ(causes_.counts().at("point clouds with senseless times of points"), clouds.size());
  EXPECT_THAT(problemOf(*clouds[0]), HasSubstr("'time' says 100, which is no time within 0.5 s"));
}

TEST_F(PointClouds, PointsOfTheVehicleNeedNoTime) {
  mount();
  const auto cloud = timedCloud<float>("time", sensor_msgs::PointField::FLOAT32, 0.01F, 100.0F);
  const float near = -0.1F;  // y of the second point
  std::memcpy(cloud->data.data() + cloud->point_step + sizeof(float), &near, sizeof(near));
  scans_.add(cloud);
  const auto scans = scans_.takeReady(0.0);
  ASSERT_THAT(scans, SizeIs(1));
  EXPECT_EQ(causes_.total(), 0U);
  EXPECT_NEAR(scans[0]->scan.sweep_s(), 0.01, 1e-6);
}

TEST_F(PointClouds, BelowTheHeightsOfObstaclesAreScansWithoutAnyAndAreTold) {
  mount();
  scans_.add(cloudOf({{5.0F, 0.0F, -50.0F}, {6.0F, 0.0F, -51.0F}}));
  EXPECT_THAT(scans_.takeReady(0.0), SizeIs(1));
  EXPECT_THAT(causes_.counts(),
              Contains(Key("point clouds without a point at the heights of obstacles")));
}

TEST_F(PointClouds, WithoutPointsSayNothing) {
  mount();
  scans_.add(cloudOf({}));
  const auto scans = scans_.takeReady(0.0);
  ASSERT_THAT(scans, SizeIs(1));
  for (const float range : scans[0]->scan.ranges_m) EXPECT_TRUE(std::isnan(range));
}

TEST_F(PointClouds, WaitForTfAndAreThenTakenInOrder) {
  const auto first = cloudOf({{5.0F, 0.0F, 0.0F}}), second = cloudOf({{6.0F, 0.0F, 0.0F}});
  second->header.stamp = ros::Time(12.5);
  scans_.add(first);
  scans_.add(second);
  EXPECT_THAT(scans_.takeReady(0.0), IsEmpty());
  EXPECT_EQ(causes_.total(), 0U);
  mount();
  const auto scans = scans_.takeReady(1.0);
  ASSERT_THAT(scans, SizeIs(2));
  EXPECT_EQ(scans[1]->header.stamp, ros::Time(12.5));
}

TEST_F(PointClouds, OfAnUnknownFrameAreRefusedAndCounted) {
  scans_.add(cloudOf({{5.0F, 0.0F, 0.0F}}));
  scans_.takeReady(0.0);
  EXPECT_THAT(scans_.takeReady(kWait_s + 1.0), IsEmpty());
  EXPECT_EQ(causes_.counts().at("unknown frame 'lidar'"), 1U);
}

TEST_F(PointClouds, ThatWaitInVainAreBounded) {
  for (int i = 0; i < 150; ++i) scans_.add(cloudOf({}));
  EXPECT_THAT(scans_.takeReady(0.0), IsEmpty());
  EXPECT_EQ(causes_.counts().at("point clouds dropped"), 50U);
  mount();
  EXPECT_THAT(scans_.takeReady(1.0), SizeIs(100));
}

TEST(SensorQueue, HoldsFewerCloudsThanOtherMessages) {
  SensorQueue queue(1000);
  for (std::size_t i = 0; i <= SensorQueue::kMostClouds; ++i) {
    EXPECT_EQ(queue.push(sensor_msgs::PointCloud2::ConstPtr(cloudOf({}))),
              i < SensorQueue::kMostClouds);
  }
  EXPECT_TRUE(queue.push(boost::make_shared<const DeadReckoning>()));
  EXPECT_EQ(queue.counts().dropped_scans, 1U);
  queue.takeAll(std::chrono::milliseconds(0));
  EXPECT_TRUE(queue.push(sensor_msgs::PointCloud2::ConstPtr(cloudOf({}))));
}

}  // namespace
}  // namespace hymm
