#include "ros/event_reader.h"

#include <cmath>
#include <limits>

#include <boost/make_shared.hpp>
#include <gmock/gmock.h>

#include "ros/pose_conversions.h"

namespace hymm {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;
using testing::Pair;

constexpr double kWait_s = 5.0;

class SensorPlaces : public testing::Test {
 protected:
  void placeSensor(const std::string& frame, const core::Pose2& T_base_sensor, double roll = 0.0) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = frame;
    transform.transform = toTransformMessage(T_base_sensor);
    if (roll != 0.0) {
      transform.transform.rotation.x = std::sin(roll / 2.0);
      transform.transform.rotation.w = std::cos(roll / 2.0);
    }
    tf_.setTransform(transform, "test", true);
  }
  SensorMountings mountings(std::optional<core::Pose2> fallback = std::nullopt) {
    return SensorMountings(tf_, "base_link", fallback, kWait_s);
  }

  tf2::BufferCore tf_;
};

using SensorMountingsTest = SensorPlaces;

TEST_F(SensorMountingsTest, TfTells) {
  placeSensor("laser", {3.0, 0.5, 0.1});
  const auto answer = mountings().find("laser", 0.0);
  ASSERT_TRUE(answer.T_base_sensor);
  EXPECT_EQ(answer.T_base_sensor->x_m, 3.0);
  EXPECT_NEAR(answer.T_base_sensor->yaw_rad, 0.1, 1e-12);
  EXPECT_EQ(answer.assumed, "");
}

TEST_F(SensorMountingsTest, ALeadingSlashOfOldRecordingsIsNoOtherFrame) {
  placeSensor("laser", {3.0, 0.5, 0.1});
  ASSERT_TRUE(mountings().find("/laser", 0.0).T_base_sensor);
}

TEST_F(SensorMountingsTest, RememberNoMoreFramesThanAVehicleHas) {
  SensorMountings places = mountings();
  placeSensor("laser", {3.0, 0.5, 0.1});
  EXPECT_TRUE(places.find("laser", 0.0).T_base_sensor);
  for (int i = 0; i < 100; ++i) places.find("laser_" + std::to_string(i), 0.0);
  EXPECT_THAT(places.find("another", 0.0).problem, HasSubstr("other frames came before"));
  EXPECT_TRUE(places.find("laser", 0.0).T_base_sensor);
}

TEST_F(SensorMountingsTest, WaitForTfThenTakeTheVehiclesDescription) {
  SensorMountings places = mountings(core::Pose2{1.0, 2.0, 0.0});
  EXPECT_TRUE(places.find("laser", 10.0).waiting);
  EXPECT_TRUE(places.find("laser", 14.9).waiting);
  const auto answer = places.find("laser", 15.1);
  ASSERT_TRUE(answer.T_base_sensor);
  EXPECT_EQ(answer.T_base_sensor->y_m, 2.0);
  EXPECT_THAT(answer.assumed, AllOf(HasSubstr("'laser'"), HasSubstr("x 1 m, y 2 m")));
}

TEST_F(SensorMountingsTest, WithoutAnyKnowledgeNameTheFrame) {
  SensorMountings places = mountings();
  places.find("nowhere", 0.0);
  const auto answer = places.find("nowhere", 6.0);
  EXPECT_FALSE(answer.T_base_sensor);
  EXPECT_FALSE(answer.waiting);
  EXPECT_THAT(answer.problem, AllOf(HasSubstr("'nowhere'"), HasSubstr("'base_link'")));
  EXPECT_THAT(places.find("", 0.0).problem, HasSubstr("names no frame"));
}

TEST_F(SensorMountingsTest, ATiltedLaserIsRefused) {
  placeSensor("tilted", {3.0, 0.0, 0.0}, 0.3);
  placeSensor("half_over", {3.0, 0.0, 0.0}, 2.8);
  EXPECT_THAT(mountings().find("tilted", 0.0).problem, HasSubstr("tilted"));
  EXPECT_THAT(mountings().find("half_over", 0.0).problem, HasSubstr("tilted"));
}

TEST_F(SensorMountingsTest, ALaserUpsideDownKeepsTheDirectionOfItsXAxis) {
  placeSensor("upside_down", {3.0, 0.5, 0.0}, core::kPi);
  const auto answer = mountings().find("upside_down", 0.0);
  ASSERT_TRUE(answer.T_base_sensor);
  EXPECT_TRUE(answer.upside_down);
  EXPECT_NEAR(answer.T_base_sensor->y_m, 0.5, 1e-12);
  EXPECT_NEAR(answer.T_base_sensor->yaw_rad, 0.0, 1e-12);
}

TEST_F(SensorMountingsTest, ANewRecordingMayHaveItsLaserElsewhere) {
  placeSensor("laser", {3.0, 0.0, 0.0});
  SensorMountings places = mountings();
  places.find("laser", 0.0);
  placeSensor("laser", {1.0, 0.0, 0.0});
  EXPECT_EQ(places.find("laser", 1.0).T_base_sensor->x_m, 3.0);  // remembered
  places.reset();
  EXPECT_EQ(places.find("laser", 2.0).T_base_sensor->x_m, 1.0);
}

class EventReaderTest : public SensorPlaces {
 protected:
  EventReaderTest() { placeSensor("laser", {3.0, 0.0, 0.0}); }

  template <class Message>
  static boost::shared_ptr<Message> stamped(const std::string& frame, double time_s = 5.0) {
    auto message = boost::make_shared<Message>();
    message->header.stamp = ros::Time(time_s);
    message->header.frame_id = frame;
    return message;
  }

  CauseLog causes_;
  EventReader reader_{mountings(), GpsConverter({1.0, 0.0}), core::PointCloudConfig(), true,
                      causes_};
};

TEST_F(EventReaderTest, ScansAndDetectionsComeWithThePlaceOfTheSensor) {
  const SensorMessage scan =
      sensor_msgs::LaserScan::ConstPtr(stamped<sensor_msgs::LaserScan>("laser"));
  const auto scan_event = reader_.read(scan, 0.0).event;
  ASSERT_TRUE(scan_event);
  EXPECT_EQ(std::get<core::ScanEvent>(*scan_event).T_base_laser.x_m, 3.0);
  const SensorMessage detections =
      LandmarkObservations::ConstPtr(stamped<LandmarkObservations>("laser"));
  const auto set = reader_.read(detections, 0.0).event;
  ASSERT_TRUE(set);
  EXPECT_EQ(std::get<core::ObservationSet>(*set).T_base_sensor.x_m, 3.0);
  EXPECT_EQ(core::timeOf(*set), 5.0);
}

TEST_F(EventReaderTest, MotionNeedsNoFrame) {
  const SensorMessage encoders = DeadReckoning::ConstPtr(stamped<DeadReckoning>(""));
  const auto event = reader_.read(encoders, 0.0).event;
  ASSERT_TRUE(event);
  EXPECT_TRUE(std::holds_alternative<core::MotionInput>(*event));
}

TEST_F(EventReaderTest, AMessageWithoutStampIsRefusedAndCounted) {
  const SensorMessage scan =
      sensor_msgs::LaserScan::ConstPtr(stamped<sensor_msgs::LaserScan>("laser", 0.0));
  EXPECT_FALSE(reader_.read(scan, 0.0).event);
  EXPECT_THAT(causes_.counts(), Contains(Key("no time stamp")));
}

TEST_F(EventReaderTest, AFrameThatNobodyKnowsIsWaitedForThenNamed) {
  const SensorMessage scan =
      sensor_msgs::LaserScan::ConstPtr(stamped<sensor_msgs::LaserScan>("nowhere"));
  EXPECT_TRUE(reader_.read(scan, 0.0).waiting);
  EXPECT_EQ(causes_.total(), 0u);
  const EventReader::Answer answer = reader_.read(scan, 6.0);
  EXPECT_FALSE(answer.event);
  EXPECT_FALSE(answer.waiting);
  EXPECT_THAT(causes_.counts(), Contains(Key("unknown frame 'nowhere'")));
}

TEST_F(EventReaderTest, AVehicleWithoutItsFrameIsToldWithTheFramesThatThereAre) {
  geometry_msgs::TransformStamped mounting;
  mounting.header.frame_id = "robot/base_footprint";
  mounting.child_frame_id = "front_laser";
  mounting.transform.rotation.w = 1.0;
  tf2::BufferCore tf;
  tf.setTransform(mounting, "test", true);
  SensorMountings mountings(tf, "base_link", std::nullopt, 0.0);
  EXPECT_THAT(
      mountings.find("front_laser", 0.0).problem,
      AllOf(HasSubstr("no frame 'base_link'"), HasSubstr("'front_laser', 'robot/base_footprint'")));
}

TEST_F(EventReaderTest, NegativeRangesAreCountedByScan) {
  const auto message = stamped<sensor_msgs::LaserScan>("laser");
  message->ranges = {1.0F, INFINITY, NAN};
  const SensorMessage scan = sensor_msgs::LaserScan::ConstPtr(message);
  EXPECT_TRUE(reader_.read(scan, 0.0).event);
  EXPECT_EQ(causes_.total(), 0u);
  message->ranges = {1.0F, -2.0F, -3.0F};
  EXPECT_TRUE(reader_.read(scan, 0.0).event);
  EXPECT_THAT(causes_.counts(), ElementsAre(Pair("scans with negative ranges", 1u)));
}

TEST_F(EventReaderTest, AFixThatCannotBeUsedIsCounted) {
  const auto fix = stamped<sensor_msgs::NavSatFix>("gps");
  fix->status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
  EXPECT_FALSE(reader_.read(sensor_msgs::NavSatFix::ConstPtr(fix), 0.0).event);
  EXPECT_THAT(causes_.counts(), Contains(Key("GPS fix refused")));
}

TEST_F(EventReaderTest, ScansFromUpsideDownAreToldAsAnUprightLaserWould) {
  placeSensor("hanging", {3.0, 0.0, 0.0}, core::kPi);
  auto message = stamped<sensor_msgs::LaserScan>("hanging");
  message->angle_min = -0.5F;
  message->angle_increment = 0.25F;
  message->ranges = {1.0F, 2.0F, 3.0F};
  const auto event = reader_.read(sensor_msgs::LaserScan::ConstPtr(message), 0.0).event;
  ASSERT_TRUE(event);
  const core::LaserScan& scan = std::get<core::ScanEvent>(*event).scan;
  EXPECT_NEAR(scan.bearing(0), 0.5, 1e-6);  // on the sensor's right, which is the vehicle's left
  EXPECT_NEAR(scan.bearing(2), 0.0, 1e-6);
}

TEST_F(EventReaderTest, DetectionsFromUpsideDownAreMirrored) {
  placeSensor("hanging", {3.0, 0.0, 0.0}, core::kPi);
  auto message = stamped<LandmarkObservations>("hanging");
  message->observations.resize(1);
  message->observations[0].bearing = 0.3;
  message->observations[0].covariance = {0.04, 0.001, 0.001, 0.01};
  const auto event = reader_.read(LandmarkObservations::ConstPtr(message), 0.0).event;
  ASSERT_TRUE(event);
  const core::Observation& seen = std::get<core::ObservationSet>(*event).observations.at(0);
  EXPECT_EQ(seen.bearing_rad, -0.3);
  EXPECT_EQ(seen.covariance(0, 1), -0.001);
  EXPECT_EQ(seen.covariance(1, 1), 0.01);
}

TEST_F(EventReaderTest, AFixWithoutCovarianceIsTakenWithAnAssumedOneAndTold) {
  auto message = stamped<sensor_msgs::NavSatFix>("gps");
  message->latitude = -33.0;
  message->longitude = 151.0;
  const auto event = reader_.read(sensor_msgs::NavSatFix::ConstPtr(message), 0.0).event;
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<core::GpsFix>(*event).covariance(1, 1),
            GpsConverter::kAssumedDeviation_m * GpsConverter::kAssumedDeviation_m);
  EXPECT_THAT(causes_.counts(), Contains(Key("GPS fix without covariance")));
}

/// The scan that a reader makes of the message.
core::LaserScan scanOf(EventReader& reader, const sensor_msgs::LaserScan::ConstPtr& message) {
  const EventReader::Answer answer = reader.read(SensorMessage(message), 0.0);
  return answer.event ? std::get<core::ScanEvent>(answer.event.value()).scan : core::LaserScan();
}

TEST_F(EventReaderTest, AScanTellsHowLongItTakesFromBeamToBeam) {
  const auto message = stamped<sensor_msgs::LaserScan>("laser");
  message->ranges.assign(100, 5.0F);
  message->time_increment = 0.001F;
  EXPECT_NEAR(scanOf(reader_, message).sweep_s(), 0.099, 1e-6);
  EXPECT_TRUE(causes_.counts().empty());

  EventReader unbelieving(mountings(), GpsConverter({0.0, 0.0}), core::PointCloudConfig(), false,
                          causes_);
  EXPECT_EQ(scanOf(unbelieving, message).sweep_s(), 0.0);
  EXPECT_EQ(scanOf(unbelieving, message).ranges_m.size(), 100U);
}

TEST_F(EventReaderTest, ATimeIncrementThatMakesNoSenseIsIgnoredAndCounted) {
  for (const float increment : {-0.001F, 1.0F, std::numeric_limits<float>::quiet_NaN()}) {
    const auto message = stamped<sensor_msgs::LaserScan>("laser");
    message->ranges.assign(100, 5.0F);
    message->time_increment = increment;
    const core::LaserScan scan = scanOf(reader_, message);
    ASSERT_EQ(scan.ranges_m.size(), 100U) << increment;
    EXPECT_EQ(scan.time_increment_s, 0.0) << increment;
  }
  EXPECT_THAT(causes_.counts(), ElementsAre(Pair("scans with an unusable time_increment", 3U)));
}

TEST_F(EventReaderTest, ATurningLaserThatDoesNotTellItsTimesIsToldWithWhatThisCosts) {
  const auto motion = stamped<DeadReckoning>("base_link");
  motion->speed = 12.0;
  reader_.read(SensorMessage(DeadReckoning::ConstPtr(motion)), 0.0);
  const auto message = stamped<sensor_msgs::LaserScan>("laser");
  message->ranges.assign(360, 5.0F);
  message->angle_increment = static_cast<float>(core::kPi / 180.0);
  reader_.read(SensorMessage(sensor_msgs::LaserScan::ConstPtr(message)), 0.0);
  EXPECT_EQ(reader_.summary(), "");  // nothing says that it turns
  message->scan_time = 0.1F;
  reader_.read(SensorMessage(sensor_msgs::LaserScan::ConstPtr(message)), 0.0);
  EXPECT_THAT(reader_.summary(), HasSubstr("moved up to 1.2 m during a scan of frame 'laser'"));
  EXPECT_THAT(causes_.counts(), ElementsAre(Pair(HasSubstr("without the times of beams"), 1U)));

  const auto told = boost::make_shared<sensor_msgs::LaserScan>(*message);
  told->time_increment = 0.1F / 360.0F;
  reader_.read(SensorMessage(sensor_msgs::LaserScan::ConstPtr(told)), 0.0);
  EXPECT_EQ(causes_.total(), 1U);
}

TEST_F(EventReaderTest, IntensitiesOfAnotherLengthThanRangesAreLeftOutAndTold) {
  const auto message = stamped<sensor_msgs::LaserScan>("laser");
  message->ranges.assign(100, 5.0F);
  message->intensities.assign(100, 7.0F);
  EXPECT_EQ(scanOf(reader_, message).intensities.size(), 100U);
  message->intensities.resize(0);
  EXPECT_EQ(scanOf(reader_, message).ranges_m.size(), 100U);
  EXPECT_EQ(causes_.total(), 0U);
  message->intensities.resize(1);
  const core::LaserScan scan = scanOf(reader_, message);
  EXPECT_EQ(scan.ranges_m.size(), 100U);
  EXPECT_TRUE(scan.intensities.empty());
  EXPECT_THAT(causes_.counts(), ElementsAre(Pair(HasSubstr("intensities"), 1U)));
}

TEST_F(EventReaderTest, AFixWithACovarianceOfZeroIsTakenWithAnAssumedOneAndTold) {
  auto message = stamped<sensor_msgs::NavSatFix>("gps");
  message->latitude = -33.0;
  message->longitude = 151.0;
  message->position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_KNOWN;
  const auto event = reader_.read(sensor_msgs::NavSatFix::ConstPtr(message), 0.0).event;
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<core::GpsFix>(*event).covariance(0, 0),
            GpsConverter::kAssumedDeviation_m * GpsConverter::kAssumedDeviation_m);
  EXPECT_THAT(causes_.counts(), Contains(Pair("GPS fix without covariance", 1U)));

  message->position_covariance[0] = 0.04;  // but the other axis is 0
  EXPECT_FALSE(reader_.read(sensor_msgs::NavSatFix::ConstPtr(message), 0.0).event);
  EXPECT_THAT(causes_.counts(), Contains(Pair("GPS fix refused", 1U)));
}

}  // namespace
}  // namespace hymm
