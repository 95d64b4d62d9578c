#include "cekf/relinearisation.h"

#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kYawDeviation_rad = 0.1;

/// How everything moves when the whole map turns by a radian about its origin.
VectorXd turnOfTheMap(const std::vector<Vector2d>& places) {
  VectorXd turn(5 + 2 * static_cast<Eigen::Index>(places.size() - 1));
  turn.head<5>() << -places[0].y(), places[0].x(), 1.0, 0.0, 0.0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    turn.segment<2>(3 + 2 * static_cast<Eigen::Index>(k)) << -places[k].y(), places[k].x();
  }
  return turn;
}

/// A map of which all is known but where north is.
class TurnedMap {
 public:
  TurnedMap(const Vector2d& vehicle, const std::vector<Vector2d>& places)
      : state_(VehicleConfig{}, true, false, true),
        filter_(vehicleMean(vehicle), vehicleCovariance(vehicle)) {
    state_.linearisePositionAt(vehicle);
    places_.push_back(vehicle);
    for (const Vector2d& place : places) {
      MatrixXd G = MatrixXd::Zero(2, 5);
      G.col(2) << -place.y(), place.x();
      RegisteredLandmark landmark;
      landmark.slot = landmark.id = filter_.append(place, G, Eigen::Matrix2d::Zero());
      landmark.position = landmark.linearised_at = place;
      registry_.add(landmark);
      places_.push_back(place);
    }
  }

  /// Takes Jacobians elsewhere: of the vehicle (0), of a landmark (its number, from 1).
  void relinearise(std::size_t number, const Vector2d& place) {
    if (number == 0) {
      core::relinearise(state_, place, filter_);
    } else {
      core::relinearise(registry_.bySlot(static_cast<int>(number) - 1), place, filter_);
    }
    places_[number] = place;
  }

  CompressedEkf& filter() { return filter_; }

  /// How far the covariance is from that of a map of which all is known but where north is.
  double inventedKnowledge() const {
    const VectorXd turn = kYawDeviation_rad * turnOfTheMap(places_);
    MatrixXd P(turn.size(), turn.size());
    const int landmarks = static_cast<int>(places_.size()) - 1;
    P.topLeftCorner<5, 5>() = filter_.vehicleCovariance();
    for (int a = 0; a < landmarks; ++a) {
      P.block<5, 2>(0, 5 + 2 * a) = filter_.vehicleLandmarkCovariance(a);
      P.block<2, 5>(5 + 2 * a, 0) = P.block<5, 2>(0, 5 + 2 * a).transpose();
      for (int b = 0; b < landmarks; ++b) {
        P.block<2, 2>(5 + 2 * a, 5 + 2 * b) = filter_.covariance(a, b);
      }
    }
    return (P - turn * turn.transpose()).norm();
  }

 private:
  static VectorXd vehicleMean(const Vector2d& place) {
    VectorXd mean = VectorXd::Zero(5);
    mean.head<2>() = place;
    return mean;
  }
  static MatrixXd vehicleCovariance(const Vector2d& place) {
    const VectorXd turn = kYawDeviation_rad * turnOfTheMap({place});
    return turn * turn.transpose();
  }

  VehicleState state_;
  CompressedEkf filter_;
  LandmarkRegistry registry_;
  std::vector<Vector2d> places_;
};

TEST(Relinearisation, KeepsTheHeadingOfTheMapUnknown) {
  TurnedMap map(Vector2d(5.0, 2.0), {Vector2d(20.0, -3.0), Vector2d(40.0, 10.0)});
  ASSERT_LT(map.inventedKnowledge(), 1e-12);
  map.relinearise(0, Vector2d(6.0, 3.0));
  map.relinearise(2, Vector2d(39.0, 12.0));
  EXPECT_LT(map.inventedKnowledge(), 1e-12);
}

TEST(Relinearisation, OfAPassiveLandmarkMakesItActiveFirst) {
  TurnedMap map(Vector2d(5.0, 2.0), {Vector2d(20.0, -3.0), Vector2d(40.0, 10.0)});
  map.filter().globalUpdate();
  ASSERT_FALSE(map.filter().isActive(1));
  map.relinearise(2, Vector2d(39.0, 12.0));
  EXPECT_TRUE(map.filter().isActive(1));
  EXPECT_LT(map.inventedKnowledge(), 1e-12);
  map.filter().globalUpdate();
  EXPECT_LT(map.inventedKnowledge(), 1e-12);
}

TEST(Relinearisation, LeavesEstimatesAsTheyAre) {
  TurnedMap map(Vector2d(5.0, 2.0), {Vector2d(20.0, -3.0)});
  map.relinearise(0, Vector2d(6.0, 3.0));
  map.relinearise(1, Vector2d(21.0, -1.0));
  EXPECT_EQ(map.filter().vehicle().head<2>(), Vector2d(5.0, 2.0));
  EXPECT_EQ(map.filter().landmark(0), Vector2d(20.0, -3.0));
}

}  // namespace
}  // namespace hymm::core
