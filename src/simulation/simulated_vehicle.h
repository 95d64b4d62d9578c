#pragma once

#include <deque>

#include "common/random.h"
#include "simulation/correlated_noise.h"
#include "simulation/route_follower.h"
#include "simulation/terrain.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// A car that really drives: it follows its route, slips a little, and its encoders (or its
/// odometry) report what it does with the errors that its description claims.
class SimulatedVehicle {
 public:
  /// The map frame is that of `route` and `terrain`. The car follows its route in plan; over hills
  /// its wheels roll farther than that.
  SimulatedVehicle(const VehicleConfig& vehicle, const SimulatedMotionConfig& sensor,
                   const DriveConfig& drive, const Route& route, double speed_mps,
                   RandomGenerator generator, Terrain terrain = {});

  /// Where base_link is at `time_s`, at most one control period after the last control(), and at
  /// most kMemory_s before it.
  Pose2 T_map_base(double time_s) const;
  static constexpr double kMemory_s = 2.0;

  /// Moves on to `time_s`, chooses what to do from there, and reports it as the sensors do.
  MotionInput control(double time_s, double period_s);

  bool isDone() const { return follower_.isDone(); }
  double progress() const { return follower_.progress(); }
  const Calibration& calibration() const { return calibration_; }

 private:
  void drawCalibration();
  void advanceNoise(double duration_s);
  MotionInput report(double time_s) const;
  AckermannInput reportEncoders(double time_s) const;
  TwistInput reportTwist(double time_s) const;

  VehicleConfig vehicle_;
  SimulatedMotionConfig sensor_;
  RandomGenerator generator_;
  Terrain terrain_;
  Calibration calibration_;
  RouteFollower follower_;
  CorrelatedNoise speed_noise_, relative_speed_noise_, turn_noise_, relative_turn_noise_,
      slip_noise_;

  /// What holds since a moment, until the next leg.
  struct Leg {
    double since_s = 0.0;
    Pose2 pose;
    RouteFollower::Command command;
    double slip_mps = 0.0;
  };
  const Leg& now() const { return legs_.back(); }
  Pose2 poseOn(const Leg& leg, double time_s) const;

  std::deque<Leg> legs_;
};

}  // namespace hymm::core
