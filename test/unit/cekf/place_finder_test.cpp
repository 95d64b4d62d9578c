#include "cekf/place_finder.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

/// A vehicle that hardly knows where it is among landmarks that it knows well.
class LostVehicle : public testing::Test {
 protected:
  LostVehicle() {
    for (const Vector2d& place :
         {Vector2d(12.0, 3.0), Vector2d(-5.0, 14.0), Vector2d(7.0, -11.0), Vector2d(-16.0, -4.0),
          Vector2d(4.0, 19.0), Vector2d(1.0, -6.0), Vector2d(-9.0, -17.0), Vector2d(18.0, -2.0)}) {
      addLandmark(place, VehicleJacobian::Zero(2, 3), 0.0);
    }
  }

  void addLandmark(const Vector2d& place, const VehicleJacobian& G, double last_seen_s) {
    RegisteredLandmark landmark;
    landmark.slot = filter.append(place, G, 1e-4 * Eigen::Matrix2d::Identity());
    landmark.id = landmark.slot;
    landmark.position = place;
    landmark.observations = 100;
    landmark.last_seen_s = last_seen_s;
    registry.add(landmark);
  }

  /// The first landmarks, as they look from where the vehicle is.
  ObservationSet seen(double time_s, std::size_t count) const {
    ObservationSet set;
    set.time_s = time_s;
    for (std::size_t k = 0; k < count; ++k) {
      set.observations.push_back(observed(inverse(truth) * registry.slots()[k].position));
    }
    return set;
  }
  ObservationSet seenAll(double time_s) const { return seen(time_s, registry.size()); }

  /// Three things that are no landmarks.
  static ObservationSet seenUnmapped(double time_s) {
    ObservationSet set;
    set.time_s = time_s;
    for (const Vector2d& place : {Vector2d(3.0, 0.0), Vector2d(0.0, 4.0), Vector2d(-2.0, -1.0)}) {
      set.observations.push_back(observed(place));
    }
    return set;
  }

  static Observation observed(const Vector2d& place) {
    Observation observation;
    observation.range_m = place.norm();
    observation.bearing_rad = std::atan2(place.y(), place.x());
    observation.covariance = Eigen::Vector2d(1e-4, 1e-6).asDiagonal();
    return observation;
  }

  std::optional<ConstellationPlace> find(const ObservationSet& set) {
    return finder.find(set, SensorPlacement{}, registry, filter);
  }

  const Pose2 truth{2.0, -1.0, 0.9};
  CompressedEkf filter{Eigen::Vector3d::Zero(), Eigen::Vector3d(25.0, 25.0, 3.0).asDiagonal()};
  LandmarkRegistry registry;
  PlaceFinder finder{PlaceFindingConfig{}, LandmarkConfig{}};
};

TEST_F(LostVehicle, IsFoundByAllThatItSees) {
  const auto place = find(seenAll(10.0));
  ASSERT_TRUE(place);
  EXPECT_LT((place->T_map_base.position() - truth.position()).norm(), 1e-6);
  EXPECT_NEAR(place->T_map_base.yaw_rad, truth.yaw_rad, 1e-6);
  EXPECT_EQ(place->landmarks, std::vector<int>({0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST_F(LostVehicle, IsNotLookedForAgainBeforeAPause) {
  EXPECT_FALSE(find(seenUnmapped(10.0)));
  EXPECT_FALSE(find(seenAll(10.9)));
  EXPECT_TRUE(find(seenAll(11.0)));
}

TEST_F(LostVehicle, IsLookedForAtOnceAfterASetThatIsTooSmallToTell) {
  for (const std::size_t few : {0U, 1U, 2U}) EXPECT_FALSE(find(seen(10.0, few)));
  EXPECT_TRUE(find(seenAll(10.1)));
}

TEST_F(LostVehicle, IsNotLostWhereItKnowsTheLandmarksSeenLast) {
  EXPECT_TRUE(finder.isLost(seenAll(100.0), registry, filter));
  for (const Vector2d& place : {Vector2d(40.0, 3.0), Vector2d(30.0, 8.0), Vector2d(35.0, -9.0)}) {
    addLandmark(place, rigidMotion(place), 50.0);
  }
  EXPECT_FALSE(finder.isLost(seenAll(100.0), registry, filter));
  for (int slot = 8; slot < 11; ++slot) registry.bySlot(slot).last_seen_s = -50.0;
  EXPECT_TRUE(finder.isLost(seenAll(100.0), registry, filter));
}

}  // namespace
}  // namespace hymm::core
