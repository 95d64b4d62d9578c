#include "ros/sample_placer.h"

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

namespace hymm {
namespace {

constexpr double kWait_s = 1.0;

class SamplePlacing : public testing::Test {
 protected:
  SamplePlacing() {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "map";
    transform.child_frame_id = "base_link";
    transform.transform.translation.x = 10.0;
    transform.transform.rotation.w = 1.0;
    tf_.setTransform(transform, "test", true);
  }

  /// Where samples at x = 1 m of the frame come to lie in map.
  std::vector<double> placesOf(const std::string& frame) {
    const auto sample = boost::make_shared<PropertySample>();
    sample->header.frame_id = frame;
    sample->header.stamp = ros::Time(5.0);
    sample->position.x = 1.0;
    placer_.add(sample, 0.0);
    std::vector<double> places;
    for (const core::PropertySample& placed : placer_.takePlaced(2.0 * kWait_s)) {
      places.push_back(placed.position.x());
    }
    return places;
  }

  tf2::BufferCore tf_;
  CauseLog causes_;
  SamplePlacer placer_{tf_, "map", kWait_s, causes_};
};

TEST_F(SamplePlacing, BringsSamplesIntoTheMap) {
  EXPECT_EQ(placesOf("map"), std::vector<double>{1.0});
  EXPECT_EQ(placesOf("base_link"), std::vector<double>{11.0});
}

TEST_F(SamplePlacing, ALeadingSlashIsNoOtherFrame) {
  EXPECT_EQ(placesOf("/map"), std::vector<double>{1.0});
  EXPECT_EQ(placesOf("/base_link"), std::vector<double>{11.0});
}

TEST_F(SamplePlacing, FramesThatTfDoesNotKnowAreRefusedAndCounted) {
  EXPECT_TRUE(placesOf("nowhere").empty());
  EXPECT_EQ(causes_.total(), 1u);
}

}  // namespace
}  // namespace hymm
