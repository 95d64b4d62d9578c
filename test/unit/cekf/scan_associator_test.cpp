#include "cekf/scan_associator.h"

#include <gtest/gtest.h>

#include "cekf/vehicle_state.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

/// Two trees ahead, a metre beside each other, as seen by a vehicle that does not know within some
/// 0.7 m how far to the side it stands.
struct TwoTrees {
  TwoTrees() : filter(Eigen::VectorXd::Zero(5), covariance()) {
    for (const Vector2d& place : {Vector2d(10.0, 0.0), Vector2d(10.0, 1.0)}) {
      RegisteredLandmark landmark;
      landmark.slot =
          filter.append(place, Eigen::MatrixXd::Zero(2, 5), 1e-4 * Eigen::Matrix2d::Identity());
      landmark.id = landmark.slot;
      landmark.type = LandmarkType::kTrunk;
      landmark.position = place;
      landmark.deviation_m = 0.02;
      registry.add(landmark);
    }
  }

  static Eigen::MatrixXd covariance() {
    Eigen::VectorXd variances(5);
    variances << 1e-6, 0.5, 1e-8, 1e-6, 1e-6;
    return variances.asDiagonal();
  }

  /// Both trees, seen from `left_m` farther right than the filter believes.
  ScanAssociation associate(const std::string& method, double left_m) {
    ObservationSet set;
    for (const double y : {0.0, 1.0}) {
      Observation observation;
      observation.range_m = std::hypot(10.0, y + left_m);
      observation.bearing_rad = std::atan2(y + left_m, 10.0);
      observation.covariance = Vector2d(1e-3, 1e-5).asDiagonal();
      observation.type = LandmarkType::kTrunk;
      set.observations.push_back(observation);
    }
    AssociationConfig config;
    config.method = method;
    return ScanAssociator(config).associate(set, SensorPlacement{}, registry, filter);
  }

  CompressedEkf filter;
  LandmarkRegistry registry;
};

TEST(ScanAssociator, PairsWhatIsNearByEitherMethod) {
  for (const char* method : {"joint", "nearest"}) {
    EXPECT_EQ(TwoTrees().associate(method, 0.1).slots, std::vector<int>({0, 1})) << method;
  }
}

TEST(ScanAssociator, TellsWhichObservationEachMeasurementIsOf) {
  for (const char* method : {"joint", "nearest"}) {
    const ScanAssociation found = TwoTrees().associate(method, 0.1);
    ASSERT_EQ(found.measurements.size(), 2U) << method;
    ASSERT_EQ(found.sightings.size(), 2U) << method;
    EXPECT_LT(found.sightings[0].bearing_rad, found.sightings[1].bearing_rad) << method;
    EXPECT_EQ(found.measurements[1].landmarks[0], 1) << method;
  }
}

TEST(ScanAssociator, SeesThatAllObservationsAreOffInTheSameWay) {
  // The first observation is nearer to the second tree than to its own.
  EXPECT_EQ(TwoTrees().associate("joint", 0.8).slots, std::vector<int>({0, 1}));
}

TEST(ScanAssociator, TakesTheNearestOfEachWhenAsked) {
  const std::vector<int> slots = TwoTrees().associate("nearest", 0.8).slots;
  EXPECT_EQ(slots[0], 1);
  EXPECT_NE(slots[1], 1);
}

/// A plantation: 20 rows of 20 trees, 1.5 m apart, around a vehicle in its middle.
struct Plantation {
  /// `shared_m`, `own_m`: deviations of an error that vehicle and trees have in common, and of the
  /// vehicle's own.
  Plantation(double shared_m, double own_m) : filter(Eigen::VectorXd::Zero(5), Matrix::Zero(5, 5)) {
    Matrix P = 1e-6 * Matrix::Identity(5, 5);
    P.topLeftCorner<2, 2>().diagonal().array() += shared_m * shared_m;
    filter = CompressedEkf(Eigen::VectorXd::Zero(5), P);
    Matrix shift = Matrix::Zero(2, 5);
    shift.leftCols<2>().setIdentity();
    for (int k = 0; k < 400; ++k) {
      RegisteredLandmark tree;
      tree.position = 1.5 * Vector2d(k % 20 - 9.5, k / 20 - 9.5);
      tree.slot = filter.append(tree.position, shift, 1e-4 * Eigen::Matrix2d::Identity());
      tree.id = tree.slot;
      tree.type = LandmarkType::kTrunk;
      tree.deviation_m = std::hypot(shared_m, 0.01) * std::sqrt(2.0);
      registry.add(tree);
    }
    filter.globalUpdate();
    more = Matrix::Zero(5, 5);
    more.topLeftCorner<2, 2>().diagonal().setConstant(own_m * own_m);
  }

  ScanAssociation associate(const std::vector<int>& trees) {
    ObservationSet set;
    for (const int k : trees) {
      const Vector2d place = registry.bySlot(k).position;
      Observation observation;
      observation.range_m = place.norm();
      observation.bearing_rad = std::atan2(place.y(), place.x());
      observation.covariance = Vector2d(1e-3, 1e-5).asDiagonal();
      observation.type = LandmarkType::kTrunk;
      set.observations.push_back(observation);
    }
    const VehicleMatrix vehicle_only = more;
    return ScanAssociator(AssociationConfig{})
        .associate(set, SensorPlacement{}, registry, filter, &vehicle_only);
  }

  using Matrix = Eigen::MatrixXd;
  CompressedEkf filter;
  LandmarkRegistry registry;
  Matrix more;
};

TEST(ScanAssociator, LooksAtTheNearestOfVeryManyLandmarks) {
  Plantation plantation(0.0, 10.0);
  plantation.associate({10});
  EXPECT_GE(plantation.filter.activeCount(), 5U);
  EXPECT_LE(plantation.filter.activeCount(), 64U);
}

TEST(ScanAssociator, KnowsItsPlaceAmongVeryManyLandmarksWhoseErrorsItShares) {
  Plantation plantation(10.0, 0.0);
  const std::vector<int> trees{10, 52, 175, 230};
  EXPECT_EQ(plantation.associate(trees).slots, trees);
}

}  // namespace
}  // namespace hymm::core
