#include "cekf/duplicate_search.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double kNow_s = 200.0;

/// Old landmarks, and a vehicle that is wrong by `error` about where it is among them, known to
/// 2 m, and maps anew what it sees.
class DuplicateSearchTest : public testing::Test {
 protected:
  DuplicateSearchTest() : filter_(Eigen::VectorXd::Zero(2), 4.0 * Eigen::Matrix2d::Identity()) {}

  int add(const Vector2d& place, const MatrixXd& G, double first_seen_s, double last_seen_s) {
    RegisteredLandmark landmark;
    landmark.slot = filter_.append(place, G, 1e-4 * Eigen::Matrix2d::Identity());
    landmark.id = landmark.slot;
    landmark.type = LandmarkType::kTrunk;
    landmark.position = place;
    landmark.deviation_m = std::sqrt(filter_.covariance(landmark.slot, landmark.slot).trace());
    landmark.first_seen_s = first_seen_s;
    landmark.last_seen_s = last_seen_s;
    registry_.add(landmark);
    return landmark.slot;
  }
  int addOld(const Vector2d& place) { return add(place, MatrixXd::Zero(2, 2), 1.0, 20.0); }
  int addAgain(const Vector2d& place) {
    return add(place + error_, MatrixXd::Identity(2, 2), 190.0, kNow_s);
  }

  std::vector<DuplicateLandmarks> find(const DuplicateSearch::AreDistinct& are_distinct =
                                           [](int, int) { return false; }) {
    return search(are_distinct).pairs;
  }
  DuplicatesFound search(const DuplicateSearch::AreDistinct& are_distinct = [](int, int) {
    return false;
  }) {
    return DuplicateSearch(landmarks_, association_, slip_)
        .find(kNow_s, Vector2d::Zero(), are_distinct, registry_, filter_);
  }

  Vector2d error_{1.5, -2.0};
  LandmarkConfig landmarks_;
  AssociationConfig association_;
  SlipConfig slip_;
  CompressedEkf filter_;
  LandmarkRegistry registry_;
};

TEST_F(DuplicateSearchTest, RecognisesAConstellationThatCameBack) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  const std::vector<DuplicateLandmarks> found = find();
  ASSERT_EQ(found.size(), 3U);
  for (const DuplicateLandmarks& pair : found) EXPECT_EQ(pair.gone, pair.kept + 3);
}

TEST_F(DuplicateSearchTest, ActivatesNoMoreThanItCanCompareHoweverManyLandmarksThereAre) {
  constexpr int kSide = 24;  // on a grid of 1 m
  for (int i = 0; i < kSide * kSide; ++i) {
    addOld({1.0 * (i % kSide - kSide / 2), 1.0 * (i / kSide - kSide / 2)});
  }
  std::vector<Vector2d> again;
  for (int i = 0; i < 100; ++i) again.emplace_back(0.5 + i % 10 - 5, 0.5 + i / 10 - 5);
  for (const Vector2d& place : again) addAgain(place);
  filter_.globalUpdate();
  filter_.finishGlobalUpdate();
  find();
  // Each of the 40 nearest, and the old ones within 3 m of it: a disc of 6 m.
  EXPECT_LT(filter_.activeCount(), 40U + 120U);
}

TEST_F(DuplicateSearchTest, TellsOfNoSlipWhereNoneIsNeeded) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  EXPECT_FALSE(search().slip);
}

TEST_F(DuplicateSearchTest, RecognisesWhatIsFartherOffThanTheFilterClaims) {
  error_ = {6.5, -7.0};  // of which 2 m each are claimed
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}, {-3.0, -8.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  const DuplicatesFound found = search();
  ASSERT_EQ(found.pairs.size(), 4U);
  for (const DuplicateLandmarks& pair : found.pairs) EXPECT_EQ(pair.gone, pair.kept + 4);
  // Beside the 2 m that are claimed, what makes 6 m of them.
  ASSERT_TRUE(found.slip);
  EXPECT_NEAR((*found.slip)(0, 0), 32.0, 0.1);
  slip_.probability = 0.0;
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, AsksForMoreLandmarksWhereASlipIsNeeded) {
  error_ = {6.5, -7.0};
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  slip_.probability = 1e-9;
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, TakesNoSlipForAnythingAmongLandmarksThatLookAlike) {
  // Rows of trees, of which the vehicle comes back to one: by a slip it may be any.
  error_ = {0.0, 9.0};
  for (int row = 0; row < 3; ++row) {
    for (int tree = 0; tree < 6; ++tree) addOld({4.0 * tree - 10.0, 6.0 * row - 6.0});
  }
  for (int tree = 0; tree < 3; ++tree) addAgain({4.0 * tree - 10.0, 0.3 * tree});
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, TakesNothingInARowThatIsTheSameOneTreeOn) {
  error_ = {1.5, 0.0};
  slip_.probability = 0.0;
  for (int tree = 0; tree < 8; ++tree) addOld({3.0 * tree - 12.0, 4.0});
  for (int tree = 3; tree < 6; ++tree) addAgain({3.0 * tree - 12.0, 4.0});
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, LeavesOneMatchAlone) {
  addOld({10.0, 0.0});
  addAgain({10.0, 0.0});
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, LeavesAnotherConstellationAlone) {
  for (const Vector2d& place : {Vector2d(10.0, 0.0), Vector2d(4.0, 9.0), Vector2d(-7.0, 12.0)}) {
    addOld(place);
  }
  for (const Vector2d& place : {Vector2d(10.0, 0.0), Vector2d(5.5, 8.0), Vector2d(-7.5, 10.0)}) {
    addAgain(place);
  }
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, TakesNothingForWhatWasSeenBesideIt) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  EXPECT_TRUE(find([](int, int) { return true; }).empty());
}

TEST_F(DuplicateSearchTest, TakesNothingForWhatWasInViewWhenItCame) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}};
  for (const Vector2d& place : places) add(place, MatrixXd::Zero(2, 2), 1.0, 195.0);
  for (const Vector2d& place : places) addAgain(place);
  EXPECT_TRUE(find().empty());
}

TEST_F(DuplicateSearchTest, ComparesNothingIfTold) {
  const std::vector<Vector2d> places = {{10.0, 0.0}, {4.0, 9.0}, {-7.0, 12.0}};
  for (const Vector2d& place : places) addOld(place);
  for (const Vector2d& place : places) addAgain(place);
  landmarks_.constellation_radius_m = 0.0;
  EXPECT_TRUE(find().empty());
}

}  // namespace
}  // namespace hymm::core
