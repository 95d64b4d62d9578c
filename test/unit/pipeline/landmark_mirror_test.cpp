#include "pipeline/landmark_mirror.h"

#include <random>
#include <set>

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

LandmarkEstimate landmarkAt(int id, double x_m) {
  LandmarkEstimate landmark;
  landmark.id = id;
  landmark.position = {x_m, 0.0};
  return landmark;
}

/// Each landmark at so many metres as its id.
LandmarkMap mapOf(std::uint64_t version, const std::vector<int>& ids) {
  LandmarkMap map;
  map.version = version;
  for (const int id : ids) map.landmarks.push_back(landmarkAt(id, 1.0 * id));
  return map;
}

LandmarkUpdate updateFrom(std::uint64_t since_version, std::uint64_t version,
                          const std::vector<LandmarkEstimate>& changed,
                          const std::vector<int>& removed_ids = {}) {
  LandmarkUpdate update;
  update.since_version = since_version;
  update.version = version;
  update.changed = changed;
  update.removed_ids = removed_ids;
  return update;
}

std::vector<int> idsOf(const LandmarkMap& map) {
  std::vector<int> ids;
  for (const LandmarkEstimate& landmark : map.landmarks) ids.push_back(landmark.id);
  return ids;
}

class LandmarkMirrorTest : public ::testing::Test {
 protected:
  LandmarkMirrorTest() { mirror_.take(mapOf(10, {1, 4})); }
  LandmarkMirror mirror_;
};

TEST_F(LandmarkMirrorTest, AppliesWhatMovedCameAndWent) {
  EXPECT_TRUE(mirror_.take(updateFrom(10, 12, {landmarkAt(2, 2.0), landmarkAt(4, 4.5)}, {1})));
  ASSERT_THAT(idsOf(mirror_.map()), testing::ElementsAre(2, 4));
  EXPECT_EQ(mirror_.map().landmarks[1].position.x(), 4.5);
  EXPECT_EQ(mirror_.map().version, 12U);
}

TEST_F(LandmarkMirrorTest, TellsThatChangesAreMissing) {
  EXPECT_FALSE(mirror_.take(updateFrom(11, 12, {}, {1})));
  EXPECT_EQ(mirror_.map().landmarks.size(), 2U);
}

TEST_F(LandmarkMirrorTest, IgnoresAMapThatAnUpdateHasOvertaken) {
  ASSERT_TRUE(mirror_.take(updateFrom(10, 12, {}, {1, 4})));
  mirror_.take(mapOf(11, {1}));
  EXPECT_TRUE(mirror_.map().landmarks.empty());
}

TEST_F(LandmarkMirrorTest, MakesChangesAgainOnAMapThatTheyOvertook) {
  EXPECT_FALSE(mirror_.take(updateFrom(11, 12, {}, {1})));
  mirror_.take(mapOf(11, {1, 7}));
  EXPECT_THAT(idsOf(mirror_.map()), testing::ElementsAre(7));
  EXPECT_EQ(mirror_.map().version, 12U);
}

TEST_F(LandmarkMirrorTest, OrdersAMapThatComesInDisorder) {
  mirror_.take(mapOf(11, {9, 2, 5}));
  EXPECT_THAT(idsOf(mirror_.map()), testing::ElementsAre(2, 5, 9));
}

TEST_F(LandmarkMirrorTest, KeepsTheFirstOfLandmarksUnderOneId) {
  LandmarkMap map;
  map.version = 11;
  map.landmarks = {landmarkAt(5, 1.0), landmarkAt(2, 2.0), landmarkAt(5, 3.0), landmarkAt(5, 4.0)};
  mirror_.take(map);
  ASSERT_THAT(idsOf(mirror_.map()), testing::ElementsAre(2, 5));
  EXPECT_EQ(mirror_.map().landmarks[1].position.x(), 1.0);
}

/// The mirror of a filter that went on from version 10 to 390, which is then started anew.
class RestartedFilterTest : public LandmarkMirrorTest {
 protected:
  RestartedFilterTest() {
    mirror_.take(mapOf(390, {1, 4}));
    EXPECT_TRUE(mirror_.take(updateTo(391, {})));
    mirror_.hear(391);
  }

  static LandmarkUpdate updateTo(std::uint64_t version, const std::vector<int>& ids) {
    return updateFrom(version - 1, version, mapOf(version, ids).landmarks);
  }

  void expect(std::uint64_t version, const std::vector<int>& ids) {
    EXPECT_EQ(mirror_.map().version, version);
    EXPECT_EQ(idsOf(mirror_.map()), ids);
    EXPECT_EQ(mirror_.restarts(), 1u);
  }
};

TEST_F(RestartedFilterTest, IsFollowedFromItsFirstChange) {
  EXPECT_TRUE(mirror_.take(updateTo(1, {0})));
  expect(1, {0});
  mirror_.take(mapOf(1, {0}));
  EXPECT_TRUE(mirror_.take(updateTo(2, {5})));
  expect(2, {0, 5});
}

TEST_F(RestartedFilterTest, IsFollowedFromItsFirstMap) {
  mirror_.take(mapOf(1, {0}));
  expect(1, {0});
  EXPECT_TRUE(mirror_.take(updateTo(1, {0})));
  EXPECT_TRUE(mirror_.take(updateTo(2, {5})));
  expect(2, {0, 5});
}

TEST_F(RestartedFilterTest, EndsTheLandmarksWhereverItSpeaksFirst) {
  mirror_.hear(1);
  expect(0, {});
  EXPECT_TRUE(mirror_.take(updateTo(1, {0})));
  mirror_.take(mapOf(1, {0}));
  mirror_.hear(2);
  expect(1, {0});
}

TEST_F(RestartedFilterTest, IsNotMixedWithALateMapOfTheOneBefore) {
  EXPECT_TRUE(mirror_.take(updateTo(1, {0})));
  mirror_.take(mapOf(391, {1, 4}));
  expect(1, {0});
  mirror_.take(mapOf(1, {0}));
  EXPECT_TRUE(mirror_.take(updateTo(2, {5})));
  expect(2, {0, 5});
}

TEST_F(RestartedFilterTest, IsNotMixedWithLateChangesOfTheOneBefore) {
  mirror_.take(mapOf(1, {0}));
  EXPECT_FALSE(mirror_.take(updateTo(392, {1})));
  expect(1, {0});
  EXPECT_TRUE(mirror_.take(updateTo(2, {5})));
  expect(2, {0, 5});
}

TEST_F(RestartedFilterTest, IsFollowedAgainAfterTheNextRestart) {
  EXPECT_TRUE(mirror_.take(updateTo(1, {0})));
  mirror_.take(mapOf(1, {0}));
  EXPECT_TRUE(mirror_.take(updateTo(2, {5})));
  mirror_.take(mapOf(0, {}));
  EXPECT_EQ(mirror_.restarts(), 2u);
  EXPECT_TRUE(mirror_.take(updateTo(1, {7})));
  EXPECT_EQ(idsOf(mirror_.map()), std::vector<int>{7});
  EXPECT_EQ(mirror_.restarts(), 2u);
}

TEST_F(LandmarkMirrorTest, TakesMapsOfARestartedFilterThatItsMapsDoNotTell) {
  ASSERT_TRUE(mirror_.take(updateFrom(10, 20, {})));
  // Its first that came; the map at 10 held.
  for (std::uint64_t version = 10; version <= 12; ++version) {
    mirror_.take(updateFrom(version - 1, version, {}));
  }
  EXPECT_EQ(mirror_.restarts(), 1u);
  mirror_.take(mapOf(12, {8}));
  EXPECT_THAT(idsOf(mirror_.map()), testing::ElementsAre(8));
  EXPECT_EQ(mirror_.restarts(), 1u);
}

TEST_F(LandmarkMirrorTest, ALateMapOfAnIntactFilterIsNoRestart) {
  ASSERT_TRUE(mirror_.take(updateFrom(10, 12, {})));
  mirror_.take(mapOf(11, {}));
  mirror_.take(mapOf(11, {}));  // latched, sent once more
  EXPECT_EQ(mirror_.restarts(), 0u);
  EXPECT_EQ(mirror_.map().landmarks.size(), 2U);
}

TEST_F(LandmarkMirrorTest, FindsEachLandmarkWhateverTheOrderOfMapsAndUpdates) {
  std::mt19937 draw(1);
  std::uniform_int_distribution<int> any_id(-3, 12);
  for (std::uint64_t version = 12; version < 500; version += 2) {
    LandmarkMap map;
    map.version = version;
    std::set<int> expected;
    for (int i = 0; i < 10; ++i) map.landmarks.push_back(landmarkAt(any_id(draw), 0.0));
    for (const LandmarkEstimate& landmark : map.landmarks) expected.insert(landmark.id);
    LandmarkUpdate update;
    update.since_version = version;
    update.version = version + 1;
    update.removed_ids = {any_id(draw), any_id(draw)};
    for (int i = 0; i < 4; ++i) update.changed.push_back(landmarkAt(any_id(draw), 1.0));
    for (const int id : update.removed_ids) expected.erase(id);
    for (const LandmarkEstimate& landmark : update.changed) expected.insert(landmark.id);

    mirror_.take(map);
    ASSERT_TRUE(mirror_.take(update));
    ASSERT_THAT(idsOf(mirror_.map()), testing::ElementsAreArray(expected));
  }
}

}  // namespace
}  // namespace hymm::core
