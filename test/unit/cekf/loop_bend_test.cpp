#include "cekf/loop_bend.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kStates = 5;
constexpr double kSide_m = 50.0;
constexpr double kStep_m = 10.0;
constexpr double kHeadingDeviation_rad = 0.1;  // of the start: nothing that follows tells it
constexpr double kLeastMove_m = 0.5;

/// A drive round a square, with a landmark every 10 m, of a vehicle that turns too far by
/// `excess_rad` at each corner; so the last landmark, which is the first, comes to lie elsewhere.
class LoopBendTest : public testing::Test {
 protected:
  explicit LoopBendTest(double excess_rad = 0.08)
      : vehicle_(VehicleConfig{}, true, false, true), filter_(VectorXd::Zero(kStates), begin()) {
    addLandmark();
    for (int corner = 0; corner < 4; ++corner) {
      for (double way = 0.0; way < kSide_m; way += kStep_m) {
        drive(kStep_m);
        addLandmark();
      }
      turn(0.5 * kPi + excess_rad);
    }
    vehicle_.linearisePositionAt(filter_.vehicle().head<2>());
  }

  static MatrixXd begin() {
    MatrixXd P = 1e-6 * MatrixXd::Identity(kStates, kStates);
    P(2, 2) = kHeadingDeviation_rad * kHeadingDeviation_rad;
    return P;
  }

  void drive(double way_m) {
    VectorXd states = filter_.vehicle();
    const Vector2d way = way_m * Vector2d(std::cos(states[2]), std::sin(states[2]));
    states.head<2>() += way;
    MatrixXd J = MatrixXd::Identity(kStates, kStates), Q = MatrixXd::Zero(kStates, kStates);
    J.col(2).head<2>() += Vector2d(-way.y(), way.x());
    Q.topLeftCorner<2, 2>() = 1e-4 * Matrix2d::Identity();
    filter_.predict(states, J, Q);
  }

  void turn(double angle_rad) {
    VectorXd states = filter_.vehicle();
    states[2] += angle_rad;
    MatrixXd Q = MatrixXd::Zero(kStates, kStates);
    Q(2, 2) = 0.03 * 0.03;
    filter_.predict(states, MatrixXd::Identity(kStates, kStates), Q);
  }

  /// Where the vehicle is.
  void addLandmark() {
    MatrixXd G = MatrixXd::Zero(2, kStates);
    G.leftCols<2>().setIdentity();
    RegisteredLandmark landmark;
    landmark.position = landmark.linearised_at = filter_.vehicle().head<2>();
    landmark.slot = landmark.id = filter_.append(landmark.position, G, 1e-4 * Matrix2d::Identity());
    registry_.add(landmark);
    slots_.push_back(landmark.slot);
  }

  /// The last landmark is the first.
  std::vector<SparseMeasurement> closing() const {
    SparseMeasurement same;
    same.H_vehicle.resize(2, 0);
    same.landmarks[0] = slots_.front();
    same.landmarks[1] = slots_.back();
    same.H_landmarks[0] = Matrix2d::Identity();
    same.H_landmarks[1] = -Matrix2d::Identity();
    same.innovation = filter_.landmark(slots_.back()) - filter_.landmark(slots_.front());
    same.noise = 1e-4 * Matrix2d::Identity();
    return {same};
  }

  bool bend() {
    return bendMap([this] { return closing(); }, kLeastMove_m, vehicle_, registry_, filter_);
  }

  double gap() const {
    return (filter_.landmark(slots_.back()) - filter_.landmark(slots_.front())).norm();
  }

  /// Deviation of the direction in which the first side lies [rad].
  double headingDeviation() const {
    const Vector2d side = filter_.landmark(slots_[4]) - filter_.landmark(slots_[0]);
    const Vector2d across(-side.y(), side.x());
    const int a = slots_[4], b = slots_[0];
    const Matrix2d between = filter_.covariance(a, a) + filter_.covariance(b, b) -
                             filter_.covariance(a, b) - filter_.covariance(b, a);
    return std::sqrt(across.dot(between * across)) / across.squaredNorm();
  }

  /// Most by which a way from one landmark to the next differs from what was driven [m].
  double stretch() const {
    double most = 0.0;
    for (std::size_t k = 0; k + 1 < slots_.size(); ++k) {
      const double way = (filter_.landmark(slots_[k + 1]) - filter_.landmark(slots_[k])).norm();
      most = std::max(most, std::abs(way - kStep_m));
    }
    return most;
  }

  VehicleState vehicle_;
  CompressedEkf filter_;
  LandmarkRegistry registry_;
  std::vector<int> slots_;
};

TEST_F(LoopBendTest, ClosingDoesNotTellTheHeadingOfTheMap) {
  ASSERT_GT(gap(), 10.0);
  const double before = headingDeviation();
  ASSERT_NEAR(before, kHeadingDeviation_rad, 0.01);
  ASSERT_TRUE(bend());
  EXPECT_NEAR(headingDeviation(), before, 0.02 * before);
  filter_.update(closing());
  EXPECT_LT(gap(), 0.05);
  EXPECT_NEAR(headingDeviation(), before, 0.02 * before);
}

TEST_F(LoopBendTest, AStraightUpdateWouldTellItAndStretchTheMap) {
  const double before = headingDeviation();
  filter_.update(closing());
  EXPECT_LT(headingDeviation(), 0.85 * before);
  EXPECT_GT(stretch(), 0.1);
}

TEST_F(LoopBendTest, TheWayIsLeftToTheUpdate) {
  const double before = gap();
  ASSERT_TRUE(bend());
  EXPECT_GT(gap(), 0.5 * before);
  filter_.update(closing());
  EXPECT_LT(gap(), 0.02);
  EXPECT_LT(filter_.landmark(slots_.front()).norm(), 0.02) << "it began there";
}

TEST_F(LoopBendTest, WhatIsTurnedIsNotStretched) {
  ASSERT_LT(stretch(), 1e-9);
  ASSERT_TRUE(bend());
  filter_.update(closing());
  EXPECT_LT(stretch(), 0.03);
}

TEST_F(LoopBendTest, JacobiansAreTakenWhereTheUpdateEnds) {
  ASSERT_TRUE(bend());
  filter_.update(closing());
  for (const int slot : slots_) {
    EXPECT_LT((registry_.bySlot(slot).linearised_at - filter_.landmark(slot)).norm(), 0.1);
  }
  EXPECT_LT((vehicle_.linearisedAt() - filter_.vehicle().head<2>()).norm(), 0.1);
}

TEST_F(LoopBendTest, PassiveLandmarksAreBentAsWell) {
  ASSERT_TRUE(filter_.globalUpdate());
  filter_.activate(slots_.front());
  filter_.activate(slots_.back());
  const double before = headingDeviation();
  ASSERT_TRUE(bend());
  filter_.update(closing());
  EXPECT_LT(stretch(), 0.03);
  EXPECT_NEAR(headingDeviation(), before, 0.02 * before);
}

TEST_F(LoopBendTest, NothingHappensToFixedLandmarks) {
  filter_.fixLandmarks(true);
  EXPECT_FALSE(bend());
}

TEST_F(LoopBendTest, NothingHappensBeforeAnUpdateThatIsRefused) {
  const MatrixXd before = filter_.activeCovariance();
  const auto senseless = [this] {
    std::vector<SparseMeasurement> measurements = closing();
    measurements[0].innovation.x() = std::numeric_limits<double>::quiet_NaN();
    return measurements;
  };
  EXPECT_FALSE(bendMap(senseless, kLeastMove_m, vehicle_, registry_, filter_));
  EXPECT_EQ(filter_.activeCovariance(), before);
}

TEST_F(LoopBendTest, NothingHappensIfThereIsNoEnd) {
  const MatrixXd before = filter_.activeCovariance();
  const VectorXd states = filter_.activeStates();
  const Vector2d linearised_at = registry_.bySlot(slots_.back()).linearised_at;
  double away_m = 0.0;
  const auto runsAway = [&] {
    std::vector<SparseMeasurement> measurements = closing();
    measurements[0].innovation.x() += away_m += 5.0;
    return measurements;
  };
  EXPECT_FALSE(bendMap(runsAway, kLeastMove_m, vehicle_, registry_, filter_));
  EXPECT_EQ(filter_.activeCovariance(), before);
  EXPECT_EQ(filter_.activeStates(), states);
  EXPECT_EQ(registry_.bySlot(slots_.back()).linearised_at, linearised_at);
}

class SmallLoopBendTest : public LoopBendTest {
 protected:
  SmallLoopBendTest() : LoopBendTest(0.001) {}
};

TEST_F(SmallLoopBendTest, NothingHappensIfNothingMovesFar) {
  const MatrixXd before = filter_.activeCovariance();
  EXPECT_FALSE(bend());
  EXPECT_EQ(filter_.activeCovariance(), before);
}

}  // namespace
}  // namespace hymm::core
