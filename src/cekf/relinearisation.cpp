#include "cekf/relinearisation.h"

#include "common/quarter_turn.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr int kYaw = 2;

}  // namespace

void relinearise(RegisteredLandmark& landmark, const Vector2d& place, CompressedEkf& filter) {
  if (filter.areLandmarksFixed()) return;
  filter.activate(landmark.slot);
  filter.addVehicleError(landmark.slot, turnedLeft(place - landmark.linearised_at), kYaw);
  landmark.linearised_at = place;
}

void relinearise(VehicleState& vehicle, const Vector2d& place, CompressedEkf& filter) {
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(2, filter.vehicleStates());
  G.col(kYaw) = turnedLeft(place - vehicle.linearisedAt());
  filter.initialiseVehicleStates(0, filter.vehicle().head<2>(), G, Eigen::Matrix2d::Zero());
  vehicle.linearisePositionAt(place);
}

}  // namespace hymm::core
