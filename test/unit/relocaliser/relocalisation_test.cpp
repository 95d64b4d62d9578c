#include "relocaliser/relocalisation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "support/shipped_config.h"
#include "tree_stand.h"

namespace hymm::core {
namespace {

using ::testing::Each;
using ::testing::Field;
using ::testing::Gt;
using ::testing::HasSubstr;

constexpr double kSpeed_mps = 4.0;
constexpr double kDoubtBegins_s = 2.0;

/// A filter that knows an irregular stand of trees, and where it would have the vehicle.
class StandingFilter : public FilterLink {
 public:
  StandingFilter() {
    const std::vector<Eigen::Vector2d> places{{8, 5},   {12, -6}, {17, 3},  {21, -9}, {26, 7},
                                              {33, -4}, {38, 9},  {44, -7}, {50, 4},  {57, -5},
                                              {63, 8},  {69, -6}, {77, 5},  {84, -8}, {90, 3}};
    for (const Eigen::Vector2d& place : places) {
      LandmarkEstimate landmark;
      landmark.id = static_cast<int>(known.size());
      landmark.position = place;
      landmark.covariance = 0.0025 * Eigen::Matrix2d::Identity();
      landmark.observations = 50;
      known.push_back(landmark);
    }
    vehicle.covariance = Eigen::Vector3d(1.0, 1.0, 0.01).asDiagonal();
  }

  std::vector<LandmarkEstimate> landmarks() override { return known; }
  std::string suspend(double time_T0_s) override {
    suspended_s = time_T0_s;
    return problem;
  }
  std::optional<FilterKnowledge> ask(const std::vector<int>& ids, std::string&) override {
    FilterKnowledge knowledge;
    JointLandmarks& joint = knowledge.estimate.landmarks;
    const auto states = static_cast<Eigen::Index>(2 * ids.size());
    joint.ids = ids;
    joint.mean.resize(states);
    joint.covariance = 0.0025 * Eigen::MatrixXd::Identity(states, states);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      joint.mean.segment<2>(static_cast<Eigen::Index>(2 * i)) =
          known[static_cast<std::size_t>(ids[i])].position;
    }
    knowledge.estimate.vehicle = vehicle;
    return knowledge;
  }
  ResumeAnswer resume(double time_T0_s, const std::vector<PlaceAtScan>& path,
                      bool elsewhere) override {
    is_elsewhere = elsewhere;
    resumed_s = time_T0_s;
    way = path;
    return {accepts, accepts ? "The loop is closed." : "It does not fit."};
  }

  std::vector<LandmarkEstimate> known;
  PosePrior vehicle;  ///< at T0
  std::string problem;
  bool accepts = true;
  bool is_elsewhere = false;
  std::optional<double> suspended_s, resumed_s;
  std::vector<PlaceAtScan> way;
};

/// A vehicle that drives straight on, up to where the filter has lost it, and beyond.
class RelocalisationTest : public ::testing::Test {
 protected:
  explicit RelocalisationTest(const RelocaliserConfig& search = {})
      : relocalisation_(search, vehicle(), filter_) {}

  /// The filter has the vehicle `error_` beside where it is.
  const SearchReport& scan() {
    scanLater();
    return workOff();
  }

  /// The same, on a machine that has no time for it.
  void scanLater() {
    relocalisation_.take(TwistInput{time_s_, kSpeed_mps, 0.0, 0.0, std::nullopt});
    time_s_ += kScanPeriod_s;
    pose_ = pose_ * Pose2{kSpeed_mps * kScanPeriod_s, 0.0, 0.0};
    PoseEstimate estimate;
    estimate.time_s = time_s_;
    estimate.T_map_base = pose_ * error_;
    estimate.covariance = Eigen::Vector3d(1.0, 1.0, 0.01).asDiagonal();
    if (time_s_ <= kDoubtBegins_s + 1e-9) {
      filter_.vehicle.mean = estimate.T_map_base;
      good_s_ = time_s_;
    }
    relocalisation_.take(seenFrom(pose_, filter_.known, time_s_), estimate);
  }

  const SearchReport& workOff() {
    while (relocalisation_.work()) {
    }
    return relocalisation_.report();
  }

  const SearchReport& begin(std::uint64_t number, double from_s) {
    relocalisation_.begin({number, from_s, time_s_});
    return relocalisation_.report();
  }

  void driveIntoDoubt() {
    while (time_s_ < kDoubtBegins_s + 1.0) scan();
  }

  const SearchReport& driveUntilDecided() {
    for (int i = 0; i < 60 && relocalisation_.report().state == SearchState::kSearching; ++i) {
      scan();
    }
    return relocalisation_.report();
  }

  StandingFilter filter_;
  Relocalisation relocalisation_;
  Pose2 pose_, error_{0.8, -1.1, 0.06};
  double time_s_ = 0.0, good_s_ = 0.0;
};

TEST_F(RelocalisationTest, SaysNothingUntilItIsAsked) {
  EXPECT_EQ(scan().state, SearchState::kIdle);
  EXPECT_FALSE(relocalisation_.report().pose);
}

TEST_F(RelocalisationTest, FindsTheVehicleFromTheLastGoodScanAndHandsBackTheWay) {
  driveIntoDoubt();
  const SearchReport begun = begin(7, good_s_);
  EXPECT_EQ(begun.state, SearchState::kSearching);
  EXPECT_EQ(begun.order, 7U);
  EXPECT_EQ(filter_.suspended_s, good_s_);
  const SearchReport& found = driveUntilDecided();
  ASSERT_EQ(found.state, SearchState::kAccepted) << found.reason;
  EXPECT_EQ(found.reason, "The loop is closed.");
  EXPECT_EQ(filter_.resumed_s, good_s_);
  EXPECT_FALSE(filter_.is_elsewhere);
  ASSERT_FALSE(filter_.way.empty());
  EXPECT_THAT(filter_.way, Each(Field(&PlaceAtScan::time_s, Gt(good_s_))));
  EXPECT_EQ(filter_.way.back().time_s, time_s_);
  // Of no scan since then the way is missing: each may close the loop.
  EXPECT_NEAR(filter_.way.front().time_s, good_s_ + kScanPeriod_s, 1e-9);
  EXPECT_EQ(static_cast<long>(filter_.way.size()),
            std::lround((time_s_ - good_s_) / kScanPeriod_s));
  for (const PlaceAtScan& place : filter_.way) {
    const double x_m = kSpeed_mps * place.time_s;
    EXPECT_NEAR(place.T_map_base.x_m, x_m, 0.15);
    EXPECT_NEAR(place.T_map_base.y_m, 0.0, 0.15);
  }
}

TEST_F(RelocalisationTest, TellsAPoseNearTheTruthWhileItSearches) {
  driveIntoDoubt();
  begin(1, good_s_);
  while (!relocalisation_.report().pose) ASSERT_TRUE(relocalisation_.work());
  const SearchReport& report = workOff();
  EXPECT_LT((report.pose->mean.position() - pose_.position()).norm(), 0.3);
  EXPECT_GT(report.pose->covariance.diagonal().minCoeff(), 0.0);
}

TEST_F(RelocalisationTest, SaysWhatTheFilterRefused) {
  filter_.accepts = false;
  driveIntoDoubt();
  begin(1, good_s_);
  EXPECT_EQ(driveUntilDecided().state, SearchState::kRefused);
  EXPECT_EQ(relocalisation_.report().reason, "It does not fit.");
}

TEST_F(RelocalisationTest, FailsWithTheFiltersReasonWhereThatCannotGoBack) {
  filter_.problem = "The scan is not kept.";
  driveIntoDoubt();
  EXPECT_EQ(begin(1, good_s_).state, SearchState::kFailed);
  EXPECT_EQ(relocalisation_.report().reason, "The scan is not kept.");
}

TEST_F(RelocalisationTest, FailsWhereItDidNotListenYet) {
  scan();
  EXPECT_EQ(begin(1, -50.0).state, SearchState::kFailed);
  EXPECT_THAT(relocalisation_.report().reason, HasSubstr("not known"));
}

TEST_F(RelocalisationTest, FailsInAMapOfOneLandmark) {
  filter_.known.resize(1);
  driveIntoDoubt();
  EXPECT_EQ(begin(1, good_s_).state, SearchState::kFailed);
  EXPECT_THAT(relocalisation_.report().reason, HasSubstr("two at least"));
}

TEST_F(RelocalisationTest, LooksWhereAnOperatorPointsTo) {
  error_ = {-30.0, 20.0, 1.0};  // the filter is of no use
  driveIntoDoubt();
  PosePrior pointed{pose_ * Pose2{1.0, 1.0, -0.1}, Eigen::Matrix3d::Zero()};
  pointed.covariance.diagonal() << 1.0, 1.0, 0.02;
  relocalisation_.wish({pointed});
  begin(1, time_s_);
  ASSERT_EQ(driveUntilDecided().state, SearchState::kAccepted) << relocalisation_.report().reason;
  EXPECT_TRUE(filter_.is_elsewhere);
  EXPECT_NEAR(filter_.way.back().T_map_base.x_m, pose_.x_m, 0.2);
}

TEST_F(RelocalisationTest, LooksAnywhereInSeveralLocalMaps) {
  error_ = {-30.0, 20.0, 1.0};
  driveIntoDoubt();
  relocalisation_.wish({});
  EXPECT_TRUE(begin(1, time_s_).anywhere);
  std::size_t maps = 0;
  while (relocalisation_.work()) maps = std::max(maps, relocalisation_.search().mapsLeft());
  EXPECT_GT(maps, 2U);
  ASSERT_EQ(driveUntilDecided().state, SearchState::kAccepted) << relocalisation_.report().reason;
  EXPECT_EQ(relocalisation_.searches(), 1U);
  EXPECT_TRUE(filter_.is_elsewhere);
  EXPECT_NEAR(filter_.way.back().T_map_base.x_m, pose_.x_m, 0.2);
}

TEST_F(RelocalisationTest, LooksAnywhereWhereItFoundNothingAroundTheFiltersPlace) {
  error_ = {-30.0, 20.0, 1.0};  // the vehicle was carried
  driveIntoDoubt();
  EXPECT_FALSE(begin(1, good_s_).anywhere);
  for (int i = 0; i < 5; ++i) ASSERT_NE(scan().state, SearchState::kAccepted);
  relocalisation_.end();
  EXPECT_TRUE(begin(2, good_s_).anywhere);
  ASSERT_EQ(driveUntilDecided().state, SearchState::kAccepted) << relocalisation_.report().reason;
  EXPECT_TRUE(filter_.is_elsewhere);
  const PlaceAtScan& last = filter_.way.back();
  EXPECT_NEAR(last.T_map_base.x_m, kSpeed_mps * last.time_s, 0.2);
}

class FewMaps : public RelocalisationTest {
 protected:
  FewMaps() : RelocalisationTest(few()) {}
  static RelocaliserConfig few() {
    RelocaliserConfig config;
    config.neighbourhoods.most = 2;
    return config;
  }
};

TEST_F(FewMaps, AreTooFewToLookAnywhereInALargeMap) {
  driveIntoDoubt();
  relocalisation_.wish({});
  EXPECT_EQ(begin(1, time_s_).state, SearchState::kFailed);
  EXPECT_THAT(relocalisation_.report().reason, HasSubstr("initialpose"));
  EXPECT_FALSE(relocalisation_.work());
}

TEST_F(RelocalisationTest, FindsTheSameHoweverFarBehindItIs) {
  const auto run = [](bool at_once) {
    RelocalisationTest_FindsTheSameHoweverFarBehindItIs_Test test;
    test.driveIntoDoubt();
    test.relocalisation_.wish({});
    test.begin(1, test.time_s_);
    if (at_once) test.workOff();
    for (int i = 0; i < 15; ++i) {
      test.scanLater();
      if (at_once) test.workOff();
    }
    test.workOff();
    EXPECT_EQ(test.relocalisation_.report().state, SearchState::kAccepted);
    return test.filter_.way;
  };
  const std::vector<PlaceAtScan> now = run(true), later = run(false);
  ASSERT_EQ(now.size(), later.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_EQ(now[i].time_s, later[i].time_s);
    EXPECT_EQ(now[i].T_map_base.vector(), later[i].T_map_base.vector());
  }
}

TEST_F(RelocalisationTest, StopsBetweenTwoPieces) {
  driveIntoDoubt();
  relocalisation_.wish({});
  begin(1, time_s_);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(relocalisation_.work());
  relocalisation_.end();
  EXPECT_FALSE(relocalisation_.work());
  EXPECT_EQ(relocalisation_.report().state, SearchState::kIdle);
}

class ShortHistory : public RelocalisationTest {
 protected:
  ShortHistory() : RelocalisationTest(forgetful()) {}
  static RelocaliserConfig forgetful() {
    RelocaliserConfig config;
    config.history_s = 10.0;
    return config;
  }
};

TEST_F(ShortHistory, EndsASearchThatCannotKeepUp) {
  driveIntoDoubt();
  begin(1, good_s_);
  while (time_s_ < 20.0) scanLater();
  EXPECT_EQ(relocalisation_.report().state, SearchState::kFailed);
  EXPECT_THAT(relocalisation_.report().reason, HasSubstr("cannot keep up"));
}

TEST_F(RelocalisationTest, WishLapsesWhereTheCekfIsInCharge) {
  driveIntoDoubt();
  relocalisation_.wish({});
  relocalisation_.end();
  EXPECT_FALSE(begin(1, good_s_).anywhere);
}

TEST_F(RelocalisationTest, SameMessagesGiveTheSameAnswer) {
  const auto run = [] {
    RelocalisationTest_SameMessagesGiveTheSameAnswer_Test test;
    test.driveIntoDoubt();
    test.begin(1, test.good_s_);
    for (int i = 0; i < 20; ++i) test.relocalisation_.work();
    return test.relocalisation_.report().pose->mean.vector();
  };
  EXPECT_EQ(run(), run());
}

TEST(RelocaliserConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("relocaliser", RelocaliserConfig());
}

}  // namespace
}  // namespace hymm::core
