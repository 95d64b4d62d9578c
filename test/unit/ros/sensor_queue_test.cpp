#include "ros/sensor_queue.h"

#include <thread>

#include <boost/make_shared.hpp>
#include <gmock/gmock.h>

#include "ros/cause_log.h"
#include "ros/filter_pairing.h"
#include "ros/scan_headers.h"
#include "ros/trajectory_path.h"

namespace hymm {
namespace {

using testing::ElementsAre;
using testing::Pair;
using testing::SizeIs;

SensorMessage scan() { return sensor_msgs::LaserScan::ConstPtr(new sensor_msgs::LaserScan); }
SensorMessage motion() { return DeadReckoning::ConstPtr(new DeadReckoning); }

TEST(SensorQueue, GivesMessagesInTheirOrder) {
  SensorQueue queue(10);
  queue.push(motion());
  queue.push(scan());
  EXPECT_EQ(queue.size(), 2u);
  const auto messages = queue.takeAll(std::chrono::milliseconds(0));
  ASSERT_THAT(messages, SizeIs(2));
  EXPECT_FALSE(isScan(messages[0]));
  EXPECT_TRUE(isScan(messages[1]));
  EXPECT_THAT(queue.takeAll(std::chrono::milliseconds(0)), SizeIs(0));
}

TEST(SensorQueue, DropsAndCountsWhatDoesNotFit) {
  SensorQueue queue(2);
  EXPECT_TRUE(queue.push(motion()));
  EXPECT_TRUE(queue.push(scan()));
  EXPECT_FALSE(queue.push(motion()));
  EXPECT_FALSE(queue.push(scan()));
  EXPECT_EQ(queue.counts().dropped, 2u);
  EXPECT_EQ(queue.counts().dropped_scans, 1u);
  queue.clear();
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_TRUE(queue.push(scan()));
}

TEST(SensorQueue, WakesWhoeverWaits) {
  SensorQueue queue(2);
  std::thread sender([&] { queue.push(scan()); });
  EXPECT_THAT(queue.takeAll(std::chrono::seconds(60)), SizeIs(1));
  sender.join();
}

std_msgs::Header headerAt(const ros::Time& stamp) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = "laser";
  return header;
}

TEST(ScanHeaders, GiveTheStampBackToTheNanosecond) {
  ScanHeaders headers;
  const ros::Time stamp(1600000000, 123456789);  // a double of seconds holds it to 238 ns
  headers.remember(headerAt(stamp));
  EXPECT_EQ(headers.take(stamp.toSec()).stamp, stamp);
}

TEST(ScanHeaders, RefusedScansAreForgotten) {
  ScanHeaders headers;
  for (int second = 1; second <= 3; ++second) headers.remember(headerAt(ros::Time(second, 0)));
  EXPECT_EQ(headers.take(3.0).frame_id, "laser");
  EXPECT_EQ(headers.take(2.0).frame_id, "");  // it came before, and is gone
}

template <class Message>
Message at(double time_s) {
  Message message;
  message.header.stamp = ros::Time(time_s);
  return message;
}

TEST(FilterPairing, BringsPoseAndHealthOfAScanTogether) {
  FilterPairing pairing;
  pairing.add(at<FilterPose>(1.0));
  EXPECT_FALSE(pairing.next());
  pairing.add(at<FilterPose>(2.0));
  pairing.add(at<FilterHealth>(1.0));
  const auto first = pairing.next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->pose.header.stamp, ros::Time(1.0));
  EXPECT_EQ(first->health.header.stamp, ros::Time(1.0));
  EXPECT_FALSE(pairing.next());
  EXPECT_EQ(pairing.unpaired(), 0u);
}

TEST(FilterPairing, LeavesOutWhatCameBeforeOneListened) {
  FilterPairing pairing;
  pairing.add(at<FilterHealth>(1.0));  // its pose was missed
  pairing.add(at<FilterPose>(2.0));
  pairing.add(at<FilterHealth>(2.0));
  const auto answer = pairing.next();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->health.header.stamp, ros::Time(2.0));
  EXPECT_EQ(pairing.unpaired(), 1u);
}

TEST(TrajectoryPath, KeepsPosesThatAreFarEnoughApart) {
  TrajectoryPath path("map", 0.5, 100);
  for (int i = 0; i <= 10; ++i) path.add(ros::Time(1 + i), {0.25 * i, 0.0, 0.0});
  ASSERT_THAT(path.message().poses, SizeIs(6));
  EXPECT_EQ(path.message().header.frame_id, "map");
  EXPECT_EQ(path.message().poses[1].pose.position.x, 0.5);
  EXPECT_EQ(path.message().header.stamp, ros::Time(11));
}

TEST(TrajectoryPath, ThinsWhatGrowsTooLongButKeepsItsBegin) {
  TrajectoryPath path("map", 0.0, 10);
  for (int i = 0; i < 1000; ++i) path.add(ros::Time(1 + i), {static_cast<double>(i), 0.0, 0.0});
  const auto& poses = path.message().poses;
  EXPECT_LE(poses.size(), 10u);
  EXPECT_GE(poses.size(), 5u);
  EXPECT_EQ(poses.front().pose.position.x, 0.0);
  EXPECT_EQ(poses.back().pose.position.x, 999.0);
}

TEST(CauseLog, CountsByCause) {
  CauseLog causes;
  causes.count("late", "A message is late.");
  causes.count("late", "A message is late.");
  causes.count("broken", "A message is broken.");
  EXPECT_THAT(causes.counts(), ElementsAre(Pair("broken", 1u), Pair("late", 2u)));
  EXPECT_EQ(causes.total(), 3u);
}

}  // namespace
}  // namespace hymm
