#include "cekf/scan_update.h"

#include <algorithm>
#include <utility>

#include <Eigen/LU>

#include "cekf/landmark_measurement.h"
#include "cekf/relinearisation.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

// A measurement counts as linear over a correction if what is neglected is below this many
// deviations of its noise.
constexpr double kNegligible = 0.1;

// Iterations have diverged if they end where they neglect more than this many.
constexpr double kFarOff = 4.0;

/// Where Jacobians are taken.
struct Places {
  Vector2d vehicle;
  std::vector<Vector2d> landmarks;  ///< of the measurements
};

Places placesOf(const std::vector<SparseMeasurement>& measurements, const VehicleState& vehicle,
                const LandmarkRegistry& registry) {
  Places places{vehicle.linearisedAt(), {}};
  for (const SparseMeasurement& measurement : measurements) {
    places.landmarks.push_back(registry.bySlot(measurement.landmarks[0]).linearised_at);
  }
  return places;
}

Places placesAmong(const VectorXd& states, const std::vector<SparseMeasurement>& measurements,
                   const CompressedEkf& filter) {
  Places places{states.head<2>(), {}};
  for (const SparseMeasurement& measurement : measurements) {
    places.landmarks.push_back(filter.landmarkAmong(states, measurement.landmarks[0]));
  }
  return places;
}

void relinearise(const Places& places, const std::vector<SparseMeasurement>& measurements,
                 VehicleState& vehicle, LandmarkRegistry& registry, CompressedEkf& filter) {
  relinearise(vehicle, places.vehicle, filter);
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    relinearise(registry.bySlot(measurements[k].landmarks[0]), places.landmarks[k], filter);
  }
}

/// H * (to - from) for the states that the measurement depends on.
Vector2d predictedChange(const SparseMeasurement& measurement, const CompressedEkf& filter,
                         const VectorXd& vehicle_change, const VectorXd& to) {
  const int slot = measurement.landmarks[0];
  return measurement.H_vehicle * vehicle_change +
         measurement.H_landmarks[0] * (filter.landmarkAmong(to, slot) - filter.landmark(slot));
}

}  // namespace

bool ScanUpdate::isLarge(const VectorXd& states_after, const CompressedEkf& filter) const {
  return !least_move_m_ || filter.largestMove(states_after) > *least_move_m_;
}

UpdateOutcome ScanUpdate::update(const ObservationSet& set, const ScanAssociation& association,
                                 VehicleState& vehicle, LandmarkRegistry& registry,
                                 CompressedEkf& filter) {
  Measurements measurements = association.measurements;
  const Places before = placesOf(measurements, vehicle, registry);
  bool is_repeated = false;
  for (int iteration = 1; iteration < max_iterations_; ++iteration) {
    std::optional<CompressedEkf::Linearised> linearised = filter.linearise(measurements);
    if (!linearised) break;
    const std::optional<VectorXd> states = filter.statesAfter(*linearised);
    if (iteration == 1 && !isLarge(*states, filter)) {
      return filter.update(measurements, std::move(*linearised));
    }
    Repeated again = linearisedAt(*states, set, association, measurements, vehicle, filter);
    if (again.neglected2 < kNegligible * kNegligible) break;
    is_repeated = true;
    measurements = std::move(again.measurements);
    if (!least_move_m_) continue;
    relinearise(placesAmong(*states, measurements, filter), measurements, vehicle, registry,
                filter);
  }
  if (!is_repeated) return filter.update(measurements);
  ++iterated_;
  std::optional<CompressedEkf::Linearised> last = filter.linearise(measurements);
  if (last) {
    const VectorXd states = filter.statesAfter(*last);
    const Repeated end = linearisedAt(states, set, association, measurements, vehicle, filter);
    if (end.neglected2 < kFarOff * kFarOff) return filter.update(measurements, std::move(*last));
  }
  ++diverged_;
  if (least_move_m_) relinearise(before, measurements, vehicle, registry, filter);
  return refusedUpdate();
}

/// The measurements with Jacobians at `states`, and innovations as of the present ones.
ScanUpdate::Repeated ScanUpdate::linearisedAt(const VectorXd& states, const ObservationSet& set,
                                              const ScanAssociation& association,
                                              const Measurements& measurements,
                                              const VehicleState& vehicle,
                                              const CompressedEkf& filter) {
  const VectorXd at = states.head(filter.vehicleStates());
  const VectorXd vehicle_change = at - filter.vehicle();
  const SensorPlacement sensor = vehicle.placement(set.T_base_sensor, at);
  Repeated again;
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const SparseMeasurement& before = measurements[k];
    const int slot = before.landmarks[0];
    SparseMeasurement now =
        landmarkMeasurement(association.sightings[k], Pose2::fromVector(at.head<3>()), sensor,
                            {slot, filter.landmarkAmong(states, slot)}, filter.vehicleStates());
    now.dependAs(before);
    const Vector2d neglected = now.innovation - before.innovation +
                               predictedChange(before, filter, vehicle_change, states);
    again.neglected2 = std::max(again.neglected2, neglected.dot(now.noise.inverse() * neglected));
    now.innovation += predictedChange(now, filter, vehicle_change, states);
    again.measurements.push_back(now);
  }
  return again;
}

}  // namespace hymm::core
