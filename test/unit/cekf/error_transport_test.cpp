#include "cekf/error_transport.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kVehicleStates = 4;  // the last is no place
constexpr int kLandmarks = 12;
constexpr int kStates = kVehicleStates + 2 * kLandmarks;

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

std::vector<int> placesOf(int landmarks) {
  std::vector<int> places{0};
  for (int k = 0; k < landmarks; ++k) places.push_back(kVehicleStates + 2 * k);
  return places;
}

VectorXd randomVector(std::mt19937& generator, double deviation) {
  std::normal_distribution<double> normal(0.0, deviation);
  VectorXd vector(kStates);
  for (double& value : vector) value = normal(generator);
  return vector;
}

MatrixXd randomCovariance(std::mt19937& generator) {
  MatrixXd A(kStates, kStates);
  for (int k = 0; k < kStates; ++k) A.col(k) = randomVector(generator, 1.0);
  return A * A.transpose();
}

/// How an error of the heading of all moves all, of 1 rad.
VectorXd headingOfAll(const VectorXd& states, const std::vector<int>& places) {
  VectorXd error = VectorXd::Zero(states.size());
  error[ErrorTransport::kHeading] = 1.0;
  for (const int place : places) {
    error.segment<2>(place) << -states[place + 1], states[place];
  }
  return error;
}

/// Moves of things that turn about the origin as one body.
VectorXd turnOfAll(const VectorXd& states, const std::vector<int>& places, double angle_rad) {
  VectorXd moves = VectorXd::Zero(states.size());
  moves[ErrorTransport::kHeading] = angle_rad;
  for (const int place : places) {
    const Vector2d at = states.segment<2>(place);
    moves.segment<2>(place) = turned(at, angle_rad) - at;
  }
  return moves;
}

TEST(ErrorTransport, WhatStaysKeepsItsErrors) {
  std::mt19937 generator(1);
  const ErrorTransport transport(placesOf(kLandmarks), randomCovariance(generator));
  const VectorXd states = randomVector(generator, 30.0);
  const VectorXd error = randomVector(generator, 1.0);
  const auto map = transport.mapAlong(states, VectorXd::Zero(kStates));
  EXPECT_TRUE((map * error).isApprox(error, 1e-9));
}

TEST(ErrorTransport, ErrorsOfAMapThatTurnsAsOneBodyTurnWithIt) {
  std::mt19937 generator(2);
  const std::vector<int> places = placesOf(kLandmarks);
  const ErrorTransport transport(places, randomCovariance(generator));
  const VectorXd states = randomVector(generator, 30.0);
  const VectorXd moves = turnOfAll(states, places, 0.3);
  const VectorXd turns = transport.turns(states, moves);
  EXPECT_TRUE(turns.isApprox(VectorXd::Constant(kLandmarks + 1, 0.3), 1e-9));
  const VectorXd error = randomVector(generator, 1.0);
  const VectorXd carried = transport.mapAlong(states, moves) * error;
  for (const int place : places) {
    EXPECT_TRUE(carried.segment<2>(place).isApprox(turned(error.segment<2>(place), 0.3), 1e-9));
  }
  EXPECT_EQ(carried[ErrorTransport::kHeading], error[ErrorTransport::kHeading]);
  EXPECT_EQ(carried[kVehicleStates - 1], error[kVehicleStates - 1]);
}

TEST(ErrorTransport, AnErrorOfTheHeadingOfAllTurnsAllWhereverItHasBeenMoved) {
  std::mt19937 generator(3);
  for (int repetition = 0; repetition < 20; ++repetition) {
    const std::vector<int> places = placesOf(kLandmarks);
    const ErrorTransport transport(places, randomCovariance(generator));
    const VectorXd states = randomVector(generator, 30.0);
    const VectorXd moves = randomVector(generator, 2.0);
    const VectorXd carried = transport.mapAlong(states, moves) * headingOfAll(states, places);
    EXPECT_TRUE(carried.isApprox(headingOfAll(states + moves, places), 1e-9));
  }
}

TEST(ErrorTransport, GroupsThatAreKnownEachInItselfAreTiedToEachOther) {
  constexpr int kGroup = 10;
  const std::vector<int> places = placesOf(2 * kGroup);
  const auto size = static_cast<Eigen::Index>(kVehicleStates + 4 * kGroup);
  MatrixXd P = 1e-4 * MatrixXd::Identity(size, size);
  VectorXd shared = VectorXd::Zero(size);  // the second group lies otherwise by 20 m, all of it
  shared.tail(2 * kGroup).setConstant(20.0);
  P += shared * shared.transpose();
  std::mt19937 generator(4);
  std::normal_distribution<double> normal(0.0, 30.0);
  VectorXd states(size), moves(size);
  for (double& value : states) value = normal(generator);
  for (double& value : moves) value = 0.1 * normal(generator);
  const ErrorTransport transport(places, P);
  const VectorXd carried = transport.mapAlong(states, moves) * headingOfAll(states, places);
  EXPECT_TRUE(carried.isApprox(headingOfAll(states + moves, places), 1e-6));
}

TEST(ErrorTransport, ALandmarkAloneOnAnothersPlaceTakesTheVehiclesHeading) {
  const std::vector<int> places = placesOf(1);
  VectorXd states = VectorXd::Zero(kVehicleStates + 2);
  const ErrorTransport transport(places, MatrixXd::Identity(states.size(), states.size()));
  VectorXd moves = VectorXd::Zero(states.size());
  moves.tail<2>() << 3.0, 4.0;
  const VectorXd carried = transport.mapAlong(states, moves) * headingOfAll(states, places);
  EXPECT_TRUE(carried.isApprox(headingOfAll(states + moves, places), 1e-9));
}

/// Links of 10 m, each with its own error of the direction, and landmarks where they meet.
class Chain {
 public:
  explicit Chain(double bend_rad) {
    double direction_rad = 0.0;
    Vector2d end(10.0, 0.0);
    for (int k = 0; k < kLandmarks; ++k) {
      ends_.push_back(end);
      direction_rad += bend_rad;
      end += turned({10.0, 0.0}, direction_rad);
    }
    vehicle_ = end;
    direction_rad_ = direction_rad;
  }

  VectorXd states() const {
    VectorXd states = VectorXd::Zero(kStates);
    states.head<3>() << vehicle_, direction_rad_;
    for (int k = 0; k < kLandmarks; ++k) {
      states.segment<2>(kVehicleStates + 2 * k) = ends_[static_cast<std::size_t>(k)];
    }
    return states;
  }

  /// What errors of the links' directions, of 0.05 rad each, and of their lengths, of 0.01 m, do.
  MatrixXd covariance() const {
    MatrixXd F = MatrixXd::Zero(kStates, 2 * kLandmarks);
    for (int k = 0; k < kLandmarks; ++k) {
      const Vector2d joint = ends_[static_cast<std::size_t>(k)];
      const Vector2d next = k + 1 < kLandmarks ? ends_[static_cast<std::size_t>(k) + 1] : vehicle_;
      const auto shift = [&](int row, const Vector2d& place) {
        F.block<2, 1>(row, 2 * k) = 0.05 * Vector2d(-(place - joint).y(), (place - joint).x());
        F.block<2, 1>(row, 2 * k + 1) = 0.01 * (next - joint).normalized();
      };
      for (int other = k + 1; other < kLandmarks; ++other) {
        shift(kVehicleStates + 2 * other, ends_[static_cast<std::size_t>(other)]);
      }
      shift(0, vehicle_);
      F(ErrorTransport::kHeading, 2 * k) = 0.05;
    }
    return F * F.transpose();
  }

 private:
  std::vector<Vector2d> ends_;
  Vector2d vehicle_;
  double direction_rad_;
};

TEST(ErrorTransport, ErrorsOfABentChainAreThoseOfOneThatWasAlwaysSo) {
  const Chain straight(0.0);
  MatrixXd P = straight.covariance();
  const ErrorTransport transport(placesOf(kLandmarks), P);
  constexpr int kSteps = 100;
  constexpr double kBend_rad = 0.1;  // at each joint: 1.2 rad in all
  for (int step = 0; step < kSteps; ++step) {
    const VectorXd from = Chain(kBend_rad * step / kSteps).states();
    const VectorXd to = Chain(kBend_rad * (step + 1) / kSteps).states();
    const auto map = transport.mapAlong(from, to - from);
    const MatrixXd TP = map * P;
    P = map * TP.transpose();
  }
  const MatrixXd expected = Chain(kBend_rad).covariance();
  EXPECT_LT((P - expected).norm(), 0.1 * expected.norm());
  EXPECT_GT((straight.covariance() - expected).norm(), 0.5 * expected.norm());
  // Across, the links' ends are known to each other to half a metre and more, along to centimetres.
  const VectorXd states = Chain(kBend_rad).states();
  for (int k = 0; k + 1 < kLandmarks; ++k) {
    const int a = kVehicleStates + 2 * k, b = a + 2;
    const Eigen::Matrix2d between =
        P.block<2, 2>(a, a) + P.block<2, 2>(b, b) - P.block<2, 2>(a, b) - P.block<2, 2>(b, a);
    const Vector2d along = (states.segment<2>(b) - states.segment<2>(a)).normalized();
    const Vector2d across = turned(along, 0.5 * kPi);
    EXPECT_GT(std::sqrt(across.dot(between * across)), 0.4) << k;
    EXPECT_LT(std::sqrt(along.dot(between * along)), 0.1) << k;
  }
}

}  // namespace
}  // namespace hymm::core
