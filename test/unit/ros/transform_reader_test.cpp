#include "ros/transform_reader.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include <gmock/gmock.h>

namespace hymm {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

geometry_msgs::TransformStamped odometry() {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base_link";
  transform.header.stamp = ros::Time(5.0);
  transform.transform.rotation.w = 1.0;
  return transform;
}

TEST(TransformReader, TakesWhatTfTakes) { EXPECT_THAT(problemOf(odometry()), IsEmpty()); }

TEST(TransformReader, RefusesNumbersThatAreNotFinite) {
  auto transform = odometry();
  transform.transform.translation.y = NAN;
  EXPECT_THAT(problemOf(transform), HasSubstr("finite"));
  transform = odometry();
  transform.transform.rotation.z = INFINITY;
  EXPECT_THAT(problemOf(transform), HasSubstr("finite"));
}

TEST(TransformReader, RefusesWhatIsNoRotation) {
  auto transform = odometry();
  transform.transform.rotation.w = 0.0;
  EXPECT_THAT(problemOf(transform), HasSubstr("quaternion"));
}

TEST(TransformReader, RefusesFramesThatConnectNothing) {
  auto transform = odometry();
  transform.child_frame_id.clear();
  EXPECT_THAT(problemOf(transform), HasSubstr("both"));
  transform.child_frame_id = transform.header.frame_id;
  EXPECT_THAT(problemOf(transform), HasSubstr("same"));
}

TEST(TransformReader, RefusesStampsThatTfCannotKeep) {
  auto transform = odometry();
  transform.header.stamp = ros::Time(std::numeric_limits<std::uint32_t>::max(), 999999999);
  EXPECT_THAT(problemOf(transform), HasSubstr("stamp"));
}

}  // namespace
}  // namespace hymm
