#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/compressed_ekf.h"
#include "cekf/landmark_registry.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {

/// Where something was, and where it is.
struct Move {
  Eigen::Vector2d from, to;
};

/// By which angle [rad] things have turned about their centre (least squares); 0 for a single one.
double turnOf(const std::vector<Move>& moves);

/// How a correction that closes a loop bends the map. What was seen long ago stays, what was seen
/// lately goes with the vehicle, and what came between goes by less: neighbours go together, and
/// turn by the same angle. A Kalman filter takes over how far they go, but its covariance says how
/// they may lie to each other in the old axes: an error of the heading with which two landmarks
/// were seen shifts one of them at right angles to the old line between them. Measured along the
/// new line, it would be found to be none.
///
/// So errors are turned along with the map. Jacobians are taken where the correction has put what
/// they are of. (relinearise() serves for corrections that turn the map as a whole: it carries the
/// vehicle's present error of the heading along, which has no part in what was seen before.)
class LoopBend {
 public:
  /// Of a correction yet to come.
  LoopBend(const LandmarkRegistry& registry, const CompressedEkf& filter);

  /// Now it has come. Active landmarks are turned, others when takeTurn() finds them active.
  void follow(VehicleState& vehicle, LandmarkRegistry& registry, CompressedEkf& filter) const;

 private:
  struct Place {
    int slot;
    Eigen::Vector2d position;
  };

  std::vector<Place> before_;  ///< of landmarks, as they came into the map
  Eigen::Vector3d pose_;       ///< of the vehicle
};

/// Turns the error of a landmark that a loop's closing has turned, if that is left to do. Makes it
/// active.
void takeTurn(RegisteredLandmark& landmark, CompressedEkf& filter);

}  // namespace hymm::core
