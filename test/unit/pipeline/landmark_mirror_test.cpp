#include "pipeline/landmark_mirror.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

LandmarkEstimate landmarkAt(int id, double x_m) {
  LandmarkEstimate landmark;
  landmark.id = id;
  landmark.position = {x_m, 0.0};
  return landmark;
}

class LandmarkMirrorTest : public ::testing::Test {
 protected:
  LandmarkMirrorTest() {
    LandmarkMap map;
    map.version = 10;
    map.landmarks = {landmarkAt(1, 1.0), landmarkAt(4, 4.0)};
    mirror_.take(map);
  }
  LandmarkMirror mirror_;
};

TEST_F(LandmarkMirrorTest, AppliesWhatMovedCameAndWent) {
  LandmarkUpdate update;
  update.since_version = 10;
  update.version = 12;
  update.changed = {landmarkAt(2, 2.0), landmarkAt(4, 4.5)};
  update.removed_ids = {1};
  EXPECT_TRUE(mirror_.take(update));
  ASSERT_EQ(mirror_.map().landmarks.size(), 2U);
  EXPECT_EQ(mirror_.map().landmarks[0].id, 2);
  EXPECT_EQ(mirror_.map().landmarks[1].position.x(), 4.5);
  EXPECT_EQ(mirror_.map().version, 12U);
}

TEST_F(LandmarkMirrorTest, TellsThatChangesAreMissing) {
  LandmarkUpdate update;
  update.since_version = 11;
  update.version = 12;
  update.removed_ids = {1};
  EXPECT_FALSE(mirror_.take(update));
  EXPECT_EQ(mirror_.map().landmarks.size(), 2U);
}

TEST_F(LandmarkMirrorTest, IgnoresAMapThatAnUpdateHasOvertaken) {
  LandmarkUpdate update;
  update.since_version = 10;
  update.version = 12;
  update.removed_ids = {1, 4};
  ASSERT_TRUE(mirror_.take(update));
  LandmarkMap old;
  old.version = 11;
  old.landmarks = {landmarkAt(1, 1.0)};
  mirror_.take(old);
  EXPECT_TRUE(mirror_.map().landmarks.empty());
}

TEST_F(LandmarkMirrorTest, MakesChangesAgainOnAMapThatTheyOvertook) {
  LandmarkUpdate update;
  update.since_version = 11;
  update.version = 12;
  update.removed_ids = {1};
  EXPECT_FALSE(mirror_.take(update));
  LandmarkMap late;
  late.version = 11;
  late.landmarks = {landmarkAt(1, 1.0), landmarkAt(7, 7.0)};
  mirror_.take(late);
  ASSERT_EQ(mirror_.map().landmarks.size(), 1U);
  EXPECT_EQ(mirror_.map().landmarks[0].id, 7);
  EXPECT_EQ(mirror_.map().version, 12U);
}

}  // namespace
}  // namespace hymm::core
