#include "cekf/loop_bend.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double kHeadingDeviation_rad = 0.1;

Vector2d turned(const Vector2d& v, double angle_rad) {
  return {std::cos(angle_rad) * v.x() - std::sin(angle_rad) * v.y(),
          std::sin(angle_rad) * v.x() + std::cos(angle_rad) * v.y()};
}

TEST(TurnOf, IsTheAngleOfThingsThatMovedAsOneBody) {
  std::vector<Move> moves;
  for (const Vector2d& place : {Vector2d(1.0, 2.0), Vector2d(-3.0, 4.0), Vector2d(10.0, 0.0)}) {
    moves.push_back({place, turned(place, 0.7) + Vector2d(5.0, -6.0)});
  }
  EXPECT_NEAR(turnOf(moves), 0.7, 1e-12);
}

TEST(TurnOf, IsNothingForASingleOne) {
  EXPECT_EQ(turnOf({{Vector2d(1.0, 2.0), Vector2d(3.0, 5.0)}}), 0.0);
}

/// Landmarks that were seen with one error of the heading, in a row ahead of a vehicle that has it
/// still, and three older ones that are known.
class LoopBendTest : public testing::Test {
 protected:
  LoopBendTest()
      : vehicle_(VehicleConfig{}, true, false, true),
        filter_(Eigen::VectorXd::Zero(5), vehicleCovariance()) {
    for (int k = 0; k < 3; ++k) old_.push_back(add({3.0, 10.0 * k}, 1.0 + k, false));
    for (int k = 0; k < 7; ++k) row_.push_back(add({10.0 + 10.0 * k, 0.0}, 100.0 + k, true));
  }

  static MatrixXd vehicleCovariance() {
    MatrixXd P = 1e-4 * MatrixXd::Identity(5, 5);
    P(2, 2) = kHeadingDeviation_rad * kHeadingDeviation_rad;
    return P;
  }

  int add(const Vector2d& place, double first_seen_s, bool shares_heading) {
    MatrixXd G = MatrixXd::Zero(2, 5);
    if (shares_heading) G.col(2) << -place.y(), place.x();
    RegisteredLandmark landmark;
    landmark.slot = landmark.id = filter_.append(place, G, 1e-6 * Matrix2d::Identity());
    landmark.position = landmark.linearised_at = place;
    landmark.first_seen_s = first_seen_s;
    registry_.add(landmark);
    return landmark.slot;
  }

  /// The row turns out to lie otherwise: its last landmark is at `place`.
  void findLastAt(const Vector2d& place) {
    filter_.activate(row_.back());
    SparseMeasurement seen;
    seen.H_vehicle.resize(2, 0);
    seen.landmarks[0] = row_.back();
    seen.H_landmarks[0] = Matrix2d::Identity();
    seen.innovation = place - filter_.landmark(row_.back());
    seen.noise = Matrix2d::Identity();  // so that the heading stays uncertain by a degree
    const LoopBend bend(registry_, filter_);
    filter_.update({seen});
    bend.follow(vehicle_, registry_, filter_);
  }

  Matrix2d relativeCovariance(int a, int b) {
    return filter_.covariance(a, a) + filter_.covariance(b, b) - filter_.covariance(a, b) -
           filter_.covariance(b, a);
  }

  VehicleState vehicle_;
  CompressedEkf filter_;
  LandmarkRegistry registry_;
  std::vector<int> old_, row_;
};

TEST_F(LoopBendTest, TheLengthOfARowIsKnownAlongItWhereverItPointsNow) {
  findLastAt(turned({70.0, 0.0}, 0.2));
  const Vector2d along = (filter_.landmark(row_[5]) - filter_.landmark(row_[1])).normalized();
  EXPECT_NEAR(std::atan2(along.y(), along.x()), 0.2, 0.01);
  const Matrix2d relative = relativeCovariance(row_[5], row_[1]);
  const Vector2d across = turned(along, 0.5 * kPi);
  EXPECT_GT(std::sqrt(across.dot(relative * across)), 0.4);
  EXPECT_LT(std::sqrt(along.dot(relative * along)), 0.01) << "its length is known to millimetres";
}

TEST_F(LoopBendTest, JacobiansAreTakenWhereThingsAreNow) {
  findLastAt(turned({70.0, 0.0}, 0.2));
  for (const int slot : row_) {
    EXPECT_TRUE(registry_.bySlot(slot).linearised_at.isApprox(filter_.landmark(slot), 1e-9));
  }
  EXPECT_TRUE(vehicle_.linearisedAt().isApprox(filter_.vehicle().head<2>(), 1e-9));
}

TEST_F(LoopBendTest, WhatStaysIsNotTurned) {
  const Matrix2d before = relativeCovariance(old_[0], old_[2]);
  findLastAt(turned({70.0, 0.0}, 0.2));
  EXPECT_NEAR(filter_.landmark(old_[0]).x(), 3.0, 1e-9);
  EXPECT_TRUE(relativeCovariance(old_[0], old_[2]).isApprox(before, 1e-6));
}

TEST_F(LoopBendTest, PassiveLandmarksAreTurnedOnceTheyAreActive) {
  filter_.globalUpdate();
  findLastAt(turned({70.0, 0.0}, 0.2));
  RegisteredLandmark& first = registry_.bySlot(row_[2]);
  EXPECT_NEAR(first.turn_rad, 0.2, 0.02);
  takeTurn(first, filter_);
  takeTurn(registry_.bySlot(row_[5]), filter_);
  EXPECT_EQ(first.turn_rad, 0.0);
  const Vector2d along = (filter_.landmark(row_[5]) - filter_.landmark(row_[2])).normalized();
  const Matrix2d relative = relativeCovariance(row_[5], row_[2]);
  EXPECT_LT(std::sqrt(along.dot(relative * along)), 0.01);
}

}  // namespace
}  // namespace hymm::core
