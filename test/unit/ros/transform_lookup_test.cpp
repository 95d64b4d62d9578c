#include "ros/transform_lookup.h"

#include <cstdint>
#include <limits>

#include <gmock/gmock.h>

namespace hymm {
namespace {

class TransformLookup : public testing::Test {
 protected:
  TransformLookup() {
    for (const double stamp : {10.0, 11.0}) {
      geometry_msgs::TransformStamped transform;
      transform.header.stamp = ros::Time(stamp);
      transform.header.frame_id = "odom";
      transform.child_frame_id = "base_link";
      transform.transform.translation.x = stamp;
      transform.transform.rotation.w = 1.0;
      tf_.setTransform(transform, "test");
    }
  }

  tf2::BufferCore tf_;
};

TEST_F(TransformLookup, GivesWhatTfKnows) {
  const TransformAnswer answer = findTransform(tf_, "odom", "base_link", ros::Time(10.5));
  ASSERT_TRUE(answer.transform);
  EXPECT_DOUBLE_EQ(answer.transform->transform.translation.x, 10.5);
}

TEST_F(TransformLookup, TellsWhyThereIsNone) {
  const TransformAnswer answer = findTransform(tf_, "map", "base_link", ros::Time(10.5));
  EXPECT_FALSE(answer.transform);
  EXPECT_THAT(answer.problem, testing::HasSubstr("map"));
}

TEST_F(TransformLookup, StampFarFromAllThatIsKnownIsNoException) {
  const ros::Time last(std::numeric_limits<std::uint32_t>::max(), 999999999);
  const TransformAnswer answer = findTransform(tf_, "odom", "base_link", last);
  EXPECT_FALSE(answer.transform);
  EXPECT_FALSE(answer.problem.empty());
}

}  // namespace
}  // namespace hymm
