#include "ros/scan_pairing.h"

#include <algorithm>
#include <memory>
#include <string>

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

namespace hymm {
namespace {

/// Messages of the scan at `second`, whose map version is `version`.
HeadedScan::ConstPtr scanAt(double second, const std::string& frame = "laser") {
  auto scan = std::make_shared<HeadedScan>();
  scan->header.stamp = scan->told_stamp = ros::Time(second);
  scan->header.frame_id = frame;
  return scan;
}

FilterPose::ConstPtr poseAt(double second, std::uint64_t version, std::uint64_t resets = 0) {
  auto pose = boost::make_shared<FilterPose>();
  pose->header.stamp = ros::Time(second);
  pose->map_version = version;
  pose->resets = resets;
  return pose;
}

LandmarkUpdate::ConstPtr updateAt(double second, std::uint64_t version, bool map_follows = false) {
  auto update = boost::make_shared<LandmarkUpdate>();
  update->header.stamp = ros::Time(second);
  update->since_version = version - 1;
  update->version = version;
  update->map_follows = map_follows;
  return update;
}

LandmarkMap::ConstPtr mapOf(std::uint64_t version, double second = 0.0) {
  auto map = boost::make_shared<LandmarkMap>();
  map->header.stamp = ros::Time(second);
  map->version = version;
  return map;
}

TEST(ScanPairing, BringsTogetherWhateverTheOrderOfArrival) {
  std::string order = "mpsu";
  do {
    SCOPED_TRACE(order);
    ScanPairing pairing;
    for (const char which : order) {
      EXPECT_FALSE(pairing.next(0.0, true).has_value());
      if (which == 'm') pairing.add(mapOf(7, 5.0));
      if (which == 'p') pairing.add(poseAt(5.0, 7), 0.0);
      if (which == 's') pairing.add(scanAt(5.0));
      if (which == 'u') pairing.add(updateAt(5.0, 7, true));
    }
    const std::optional<PairedScan> paired = pairing.next(0.0, true);
    ASSERT_TRUE(paired.has_value());
    EXPECT_EQ(paired->scan->header.stamp, ros::Time(5.0));
    EXPECT_EQ(paired->pose->map_version, 7u);
    EXPECT_EQ(paired->update->version, 7u);
    EXPECT_EQ(paired->map->version, 7u);
    EXPECT_FALSE(pairing.next(0.0, true).has_value());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(ScanPairing, WaitsForAWholeMapThatIsAnnounced) {
  ScanPairing pairing;
  pairing.add(scanAt(5.0));
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(updateAt(5.0, 7, true));
  pairing.add(mapOf(6));  // not this one
  EXPECT_FALSE(pairing.next(3.0, true).has_value());
  pairing.add(mapOf(7));
  EXPECT_EQ(pairing.next(3.0, true)->map->version, 7u);
}

TEST(ScanPairing, GivesUpAWholeMapThatDoesNotCome) {
  ScanPairing pairing;
  pairing.add(scanAt(5.0));
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(updateAt(5.0, 7, true));
  EXPECT_FALSE(pairing.next(9.0, true).has_value());
  const std::optional<PairedScan> paired = pairing.next(11.0, true);
  ASSERT_TRUE(paired.has_value());
  EXPECT_EQ(paired->map, nullptr);
  EXPECT_NE(paired->scan, nullptr);
  EXPECT_EQ(pairing.counts().missing_maps, 1u);
}

TEST(ScanPairing, AWholeMapThatALaterOneHasPassedWillNotCome) {
  ScanPairing pairing;
  pairing.add(scanAt(5.0));
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(updateAt(5.0, 7, true));
  pairing.add(mapOf(9, 4.0));  // of a filter that was started anew since
  EXPECT_FALSE(pairing.next(0.0, true).has_value());
  pairing.add(mapOf(8, 6.0));
  const std::optional<PairedScan> paired = pairing.next(0.0, true);
  ASSERT_TRUE(paired.has_value());
  EXPECT_EQ(paired->map, nullptr);
  EXPECT_EQ(pairing.counts().missing_maps, 1u);
}

TEST(ScanPairing, WaitsForNoScanWhereThereAreNone) {
  ScanPairing pairing;
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(updateAt(5.0, 7));
  EXPECT_FALSE(pairing.next(1.0, true).has_value());
  const std::optional<PairedScan> paired = pairing.next(1.0, false);
  ASSERT_TRUE(paired.has_value());
  EXPECT_EQ(paired->scan, nullptr);
  EXPECT_EQ(pairing.counts().missing_scans, 0u);
}

TEST(ScanPairing, AScanThatALaterOneHasPassedWillNotCome) {
  ScanPairing pairing;
  pairing.add(scanAt(5.2));
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(updateAt(5.0, 7));
  EXPECT_EQ(pairing.next(0.0, true)->scan, nullptr);
  EXPECT_EQ(pairing.counts().missing_scans, 1u);
  pairing.add(poseAt(5.2, 8), 0.0);
  pairing.add(updateAt(5.2, 8));
  EXPECT_NE(pairing.next(0.0, true)->scan, nullptr);
}

TEST(ScanPairing, CountsScansThatTheFilterRefused) {
  ScanPairing pairing;
  for (const double second : {5.0, 5.2, 5.4}) pairing.add(scanAt(second));
  pairing.add(poseAt(5.4, 7), 0.0);
  pairing.add(updateAt(5.4, 7));
  EXPECT_EQ(pairing.next(0.0, true)->scan->header.stamp, ros::Time(5.4));
  EXPECT_EQ(pairing.counts().unused_scans, 2u);
}

TEST(ScanPairing, HandsOnAnUpdateWhosePoseGotLost) {
  ScanPairing pairing;
  pairing.add(updateAt(5.0, 7));
  pairing.add(updateAt(5.2, 8));
  pairing.add(scanAt(5.2));
  pairing.add(poseAt(5.2, 8), 0.0);
  const std::optional<PairedScan> alone = pairing.next(0.0, true);
  ASSERT_TRUE(alone.has_value());
  EXPECT_EQ(alone->update->version, 7u);
  EXPECT_EQ(alone->pose, nullptr);
  EXPECT_EQ(pairing.next(0.0, true)->pose->map_version, 8u);
  EXPECT_EQ(pairing.counts().missing_poses, 1u);
}

TEST(ScanPairing, LeavesOutAPoseWhoseUpdateGotLost) {
  ScanPairing pairing;
  pairing.add(poseAt(5.0, 7), 0.0);
  pairing.add(poseAt(5.2, 8), 0.0);
  pairing.add(scanAt(5.0));
  pairing.add(scanAt(5.2));
  pairing.add(updateAt(5.2, 8));
  EXPECT_EQ(pairing.next(0.0, true)->pose->map_version, 8u);
  EXPECT_EQ(pairing.counts().missing_poses, 1u);
}

TEST(ScanPairing, AFilterThatWasStartedAnewIsFollowedAgain) {
  ScanPairing pairing;
  pairing.add(updateAt(90.0, 400));  // the last word of the one before
  pairing.add(poseAt(90.2, 1), 0.0);
  pairing.add(updateAt(90.2, 1));
  pairing.add(scanAt(90.2));
  EXPECT_EQ(pairing.next(0.0, true)->update->version, 400u);
  const std::optional<PairedScan> paired = pairing.next(0.0, true);
  ASSERT_TRUE(paired.has_value());
  EXPECT_EQ(paired->pose->map_version, 1u);
}

TEST(ScanPairing, AFilterThatWasStartedAnewDoesNotWaitForTheLastWordsOfTheOneBefore) {
  ScanPairing pairing;
  pairing.add(poseAt(90.0, 400), 0.0);
  pairing.add(updateAt(90.0, 400, true));  // its map never comes
  EXPECT_FALSE(pairing.next(0.0, false).has_value());
  pairing.add(poseAt(90.2, 1), 0.0);
  EXPECT_EQ(pairing.counts().missing_poses, 1u);
  EXPECT_FALSE(pairing.next(0.0, false).has_value());  // its update is still on its way
  pairing.add(updateAt(90.2, 1));
  EXPECT_EQ(pairing.next(0.0, false)->update->version, 400u);
  const std::optional<PairedScan> paired = pairing.next(0.0, false);
  ASSERT_TRUE(paired.has_value());
  EXPECT_EQ(paired->pose->map_version, 1u);
}

TEST(ScanPairing, ScansBeforeARestartInAnotherRecordingDoNotPassThoseOfTheNext) {
  ScanPairing pairing;
  pairing.add(poseAt(90.0, 400), 0.0);
  pairing.add(updateAt(90.0, 400));
  EXPECT_TRUE(pairing.next(0.0, false).has_value());
  pairing.add(scanAt(91.0));  // while no filter ran
  pairing.add(scanAt(5.0));
  pairing.add(scanAt(5.2));
  pairing.add(poseAt(5.0, 1), 0.0);
  pairing.add(updateAt(5.0, 1));
  EXPECT_NE(pairing.next(0.0, true)->scan, nullptr);
}

TEST(ScanPairing, ScansOfTheRecordingBeforeDoNotPassThoseOfTheNext) {
  ScanPairing pairing;
  pairing.add(scanAt(90.0));  // refused by the filter: without a pose
  pairing.add(scanAt(5.0));
  pairing.add(scanAt(5.2));
  pairing.add(poseAt(5.0, 9, 1), 0.0);
  pairing.add(updateAt(5.0, 9));
  EXPECT_EQ(pairing.next(0.0, true)->scan->header.stamp, ros::Time(5.0));
  pairing.add(poseAt(5.2, 10, 1), 0.0);
  pairing.add(updateAt(5.2, 10));
  EXPECT_EQ(pairing.next(0.0, true)->scan->header.stamp, ros::Time(5.2));
}

TEST(ScanPairing, MemoryIsBoundedAndDropsAreCounted) {
  ScanPairing pairing;
  for (int i = 0; i < 6000; ++i) pairing.add(scanAt(1.0 + 0.1 * i));
  EXPECT_EQ(pairing.counts().dropped_scans, 1000u);
  EXPECT_EQ(pairing.counts().overflows, 1000u);
}

TEST(ScanPairing, FindsACloudByTheStampOfItsFirstPointOrByTheOneThatWasTold) {
  // A filter that does not use the times of points takes the cloud as of the stamp told.
  for (const double pose_s : {4.9, 5.0}) {
    ScanPairing pairing;
    auto scan = std::make_shared<HeadedScan>();
    scan->header.stamp = ros::Time(4.9);
    scan->told_stamp = ros::Time(5.0);
    pairing.add(scan);
    pairing.add(poseAt(pose_s, 7), 0.0);
    pairing.add(updateAt(pose_s, 7));
    const std::optional<PairedScan> paired = pairing.next(0.0, true);
    ASSERT_TRUE(paired.has_value());
    EXPECT_EQ(paired->scan, scan) << pose_s;
  }
}

TEST(ScanPairing, TakesOneScanOfAStampFromEachSensor) {
  ScanPairing pairing;
  pairing.add(scanAt(5.0, "front"));
  pairing.add(scanAt(5.0, "front"));  // the filter refuses it
  pairing.add(scanAt(5.0, "rear"));
  EXPECT_EQ(pairing.counts().unused_scans, 1U);
  for (const std::string frame : {"front", "rear"}) {
    const std::uint64_t version = frame == "front" ? 7 : 8;
    pairing.add(poseAt(5.0, version), 0.0);
    pairing.add(updateAt(5.0, version));
    const std::optional<PairedScan> paired = pairing.next(0.0, true);
    ASSERT_TRUE(paired.has_value());
    EXPECT_EQ(paired->scan->header.frame_id, frame);
  }
}

}  // namespace
}  // namespace hymm
