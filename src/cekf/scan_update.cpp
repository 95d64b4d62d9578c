#include "cekf/scan_update.h"

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
  for (int iteration = 1; iteration < max_iterations_; ++iteration) {
    std::optional<CompressedEkf::Linearised> linearised = filter.linearise(measurements);
    if (!linearised) break;
    const std::optional<VectorXd> states = filter.statesAfter(*linearised);
    if (iteration == 1 && !isLarge(*states, filter)) {
      return filter.update(measurements, std::move(*linearised));
    }
    const VectorXd at = states->head(filter.vehicleStates());
    const VectorXd vehicle_change = at - filter.vehicle();
    const SensorPlacement sensor = vehicle.placement(set.T_base_sensor, at);
    double worst2 = 0.0;
    Measurements again;
    for (std::size_t k = 0; k < measurements.size(); ++k) {
      const SparseMeasurement& before = measurements[k];
      const int slot = before.landmarks[0];
      SparseMeasurement now =
          landmarkMeasurement(association.sightings[k], Pose2::fromVector(at.head<3>()), sensor,
                              {slot, filter.landmarkAmong(*states, slot)}, filter.vehicleStates());
      now.dependAs(before);
      const Vector2d neglected = now.innovation - before.innovation +
                                 predictedChange(before, filter, vehicle_change, *states);
      worst2 = std::max(worst2, neglected.dot(now.noise.inverse() * neglected));
      now.innovation += predictedChange(now, filter, vehicle_change, *states);
      again.push_back(now);
    }
    if (worst2 < kNegligible * kNegligible) break;
    if (iteration == 1) ++iterated_;
    measurements = std::move(again);
    if (!least_move_m_) continue;
    relinearise(vehicle, at.head<2>(), filter);
    for (const SparseMeasurement& measurement : measurements) {
      const int slot = measurement.landmarks[0];
      relinearise(registry.bySlot(slot), filter.landmarkAmong(*states, slot), filter);
    }
  }
  return filter.update(measurements);
}

}  // namespace hymm::core
