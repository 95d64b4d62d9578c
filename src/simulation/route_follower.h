#pragma once

#include <vector>

#include "simulation/route.h"
#include "simulation/simulation_config.h"

namespace hymm::core {

/// Drives a car along a route: pure pursuit for the steering, a speed that the curves and the end
/// of the drive allow.
class RouteFollower {
 public:
  /// `speed_mps` is the world's own, for a drive that asks for none.
  RouteFollower(const Route& route, const DriveConfig& drive, const VehicleConfig& vehicle,
                double speed_mps);

  struct Command {
    double speed_mps = 0.0;
    double steering_rad = 0.0;
  };

  /// What to do at this pose for the next `duration_s`, after having done `last`.
  Command follow(const Pose2& T_route_base, const Command& last, double duration_s);

  bool isDone() const { return along_m_ >= end_m_ - kArrived_m; }
  double progress() const { return along_m_ / end_m_; }

 private:
  static constexpr double kArrived_m = 0.1;

  double speedLimit(double along_m) const;
  void limitSpeeds(double speed_mps);

  Route route_;
  DriveConfig drive_;
  double wheelbase_m_, max_steering_rad_;
  std::vector<double> speed_limits_;  ///< at even steps along the route
  double along_m_ = 0.0;
  double end_m_;
};

}  // namespace hymm::core
