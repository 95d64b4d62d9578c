// The association of one typical scan, by clutter and by density of landmarks.

#include <cmath>
#include <string>

#include "benchmark/benchmarks.h"
#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/observation_model.h"
#include "cekf/scan_associator.h"
#include "cekf/vehicle_state.h"
#include "common/random.h"
#include "simulation/simulation_config.h"

namespace hymm::benchmarks {
namespace {

using core::Pose2;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kRange_m = 28.0;
constexpr double kRangeDeviation_m = 0.05;
constexpr double kBearingDeviation_rad = 0.005;
constexpr double kPositionDeviation_m = 0.2;
constexpr double kHeadingDeviation_rad = 0.01;

Vector2d placeInView(core::RandomGenerator& generator) {
  const double range_m = kRange_m * std::sqrt(core::sampleUniform(generator, 0.01, 1.0));
  const double bearing = core::sampleUniform(generator, -core::kPi / 2.0, core::kPi / 2.0);
  return {range_m * std::cos(bearing), range_m * std::sin(bearing)};
}

core::Observation observationOf(const Vector2d& place, core::RandomGenerator& generator) {
  core::Observation observation;
  observation.range_m = place.norm() + core::sampleNormal(generator, kRangeDeviation_m);
  observation.bearing_rad =
      std::atan2(place.y(), place.x()) + core::sampleNormal(generator, kBearingDeviation_rad);
  observation.covariance =
      Vector2d(kRangeDeviation_m, kBearingDeviation_rad).cwiseAbs2().asDiagonal();
  observation.type = core::LandmarkType::kTrunk;
  return observation;
}

/// A half disc of landmarks before a vehicle that has moved a little since it mapped them, and what
/// it sees now: each landmark, and clutter.
struct TypicalScan {
  TypicalScan(double landmarks_per_100_m2, int clutter)
      : vehicle(core::simulatedCar(), true, false),
        filter(vehicle.initialState(), vehicle.initialCovariance()) {
    core::RandomGenerator generator(1);
    const double area_m2 = 0.5 * core::kPi * kRange_m * kRange_m;
    const int count = static_cast<int>(std::lround(landmarks_per_100_m2 * area_m2 / 100.0));
    const core::SensorPlacement sensor;
    for (int id = 0; id < count; ++id) {
      const Vector2d place = placeInView(generator);
      addLandmark(id, place, sensor);
      set.observations.push_back(observationOf(place, generator));
    }
    for (int i = 0; i < clutter; ++i) {
      set.observations.push_back(observationOf(placeInView(generator), generator));
    }
    const auto n = filter.vehicleStates();
    MatrixXd Q = MatrixXd::Zero(n, n);
    Q.diagonal().head<3>() << std::pow(kPositionDeviation_m, 2), std::pow(kPositionDeviation_m, 2),
        std::pow(kHeadingDeviation_rad, 2);
    VectorXd moved = filter.vehicle();
    moved.head<3>() += Eigen::Vector3d(kPositionDeviation_m, 0.0, kHeadingDeviation_rad);
    filter.predict(moved, MatrixXd::Identity(n, n), Q);
  }

  void addLandmark(int id, const Vector2d& place, const core::SensorPlacement& sensor) {
    const core::LocatedLandmark located =
        core::locateLandmark(Pose2{}, Pose2{}, place.norm(), std::atan2(place.y(), place.x()));
    core::RegisteredLandmark landmark;
    landmark.id = id;
    landmark.slot =
        filter.append(place, core::vehicleJacobian(located, sensor, filter.vehicleStates()),
                      0.0025 * Matrix2d::Identity());
    landmark.type = core::LandmarkType::kTrunk;
    landmark.position = place;
    landmark.deviation_m = 0.07;
    registry.add(landmark);
  }

  core::VehicleState vehicle;
  core::CompressedEkf filter;
  core::LandmarkRegistry registry;
  core::ObservationSet set;
};

void associate(benchmark::State& state, double landmarks_per_100_m2, int clutter) {
  TypicalScan scan(landmarks_per_100_m2, clutter);
  const core::ScanAssociator associator{core::AssociationConfig{}};
  core::ScanAssociation association;
  for (auto _ : state) {
    association =
        associator.associate(scan.set, core::SensorPlacement{}, scan.registry, scan.filter);
    benchmark::DoNotOptimize(association.slots.data());
  }
  state.counters["observations"] = static_cast<double>(scan.set.observations.size());
  state.counters["associated"] = static_cast<double>(association.measurements.size());
  state.counters["ambiguous"] = association.ambiguous;
}

}  // namespace

void registerAssociationBenchmarks(Registration& registration) {
  const auto in_microseconds = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMicrosecond);
  };
  for (const int clutter : {0, 5, 20, 80}) {
    registration.add(
        "BM_Association/" + std::to_string(clutter),
        [clutter](benchmark::State& state) { associate(state, 1.0, clutter); }, in_microseconds);
  }
  for (const int density : {1, 2, 4, 8}) {
    registration.add(
        "BM_AssociationByDensity/" + std::to_string(density),
        [density](benchmark::State& state) { associate(state, density, 0); }, in_microseconds);
  }
}

}  // namespace hymm::benchmarks
