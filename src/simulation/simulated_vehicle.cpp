#include "simulation/simulated_vehicle.h"

#include <cmath>
#include <iterator>
#include <utility>

namespace hymm::core {
namespace {

/// The exact end of a motion at constant velocity in the vehicle's own axes.
Pose2 movedAlongArc(const Pose2& from, double forward_mps, double left_mps, double turn_radps,
                    double duration_s) {
  const double turn = turn_radps * duration_s;
  // The chord points half the turn ahead and is shorter than the arc by sin(t/2) / (t/2).
  const double half = turn / 2.0;
  const double shortened = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  const Eigen::Vector2d arc(forward_mps * duration_s, left_mps * duration_s);
  const Pose2 midway{from.x_m, from.y_m, from.yaw_rad + half};
  const Eigen::Vector2d end = midway * Eigen::Vector2d(shortened * arc);
  return {end.x(), end.y(), wrapAngle(from.yaw_rad + turn)};
}

double yawRate(const RouteFollower::Command& command, double wheelbase_m) {
  return command.speed_mps * std::tan(command.steering_rad) / wheelbase_m;
}

}  // namespace

SimulatedVehicle::SimulatedVehicle(const VehicleConfig& vehicle,
                                   const SimulatedMotionConfig& sensor, const DriveConfig& drive,
                                   const Route& route, double speed_mps, RandomGenerator generator,
                                   Terrain terrain)
    : vehicle_(vehicle),
      sensor_(sensor),
      generator_(generator),
      terrain_(std::move(terrain)),
      calibration_{sensor.speed_scale, sensor.turn_scale, sensor.turn_offset},
      follower_(route, drive, vehicle, speed_mps),
      speed_noise_(vehicle.noise.correlationTimes_s()[0], generator_),
      relative_speed_noise_(vehicle.noise.correlationTimes_s()[0], generator_),
      turn_noise_(vehicle.noise.correlation_time_s, generator_),
      relative_turn_noise_(vehicle.noise.correlationTimes_s()[2], generator_),
      slip_noise_(vehicle.noise.correlation_time_s, generator_),
      legs_{{0.0, route.at(0.0), {}, 0.0}} {
  drawCalibration();
}

void SimulatedVehicle::drawCalibration() {
  if (!sensor_.draw_calibration) return;
  const CalibrationPrior& prior = vehicle_.calibration;
  const bool ackermann = sensor_.output == "dead_reckoning";
  calibration_.speed_scale += sampleNormal(generator_, prior.speed_scale_deviation);
  calibration_.turn_scale += sampleNormal(generator_, prior.turn_scale_deviation);
  calibration_.turn_offset +=
      sampleNormal(generator_, ackermann ? prior.steering_offset_deviation_rad
                                         : prior.yaw_rate_offset_deviation_radps);
}

Pose2 SimulatedVehicle::poseOn(const Leg& leg, double time_s) const {
  return movedAlongArc(leg.pose, leg.command.speed_mps, leg.slip_mps,
                       yawRate(leg.command, vehicle_.ackermann.wheelbase_m), time_s - leg.since_s);
}

Pose2 SimulatedVehicle::T_map_base(double time_s) const {
  auto leg = legs_.rbegin();
  while (leg->since_s > time_s && std::next(leg) != legs_.rend()) ++leg;
  return poseOn(*leg, time_s);
}

MotionInput SimulatedVehicle::control(double time_s, double period_s) {
  Leg next = now();
  next.pose = poseOn(now(), time_s);
  next.since_s = time_s;
  advanceNoise(time_s - now().since_s);
  next.command = follower_.isDone() ? RouteFollower::Command{}
                                    : follower_.follow(next.pose, next.command, period_s);
  next.slip_mps = sensor_.noise_scale * vehicle_.noise.lateral_deviation_relative *
                  next.command.speed_mps * slip_noise_.value();
  legs_.push_back(next);
  while (legs_.size() > 1 && legs_[1].since_s < time_s - kMemory_s) legs_.pop_front();
  return report(time_s);
}

void SimulatedVehicle::advanceNoise(double duration_s) {
  for (CorrelatedNoise* noise :
       {&speed_noise_, &relative_speed_noise_, &turn_noise_, &relative_turn_noise_, &slip_noise_}) {
    noise->advance(duration_s, generator_);
  }
}

MotionInput SimulatedVehicle::report(double time_s) const {
  if (sensor_.output == "odom") return reportTwist(time_s);
  return reportEncoders(time_s);
}

AckermannInput SimulatedVehicle::reportEncoders(double time_s) const {
  const AckermannGeometry& geometry = vehicle_.ackermann;
  const RouteFollower::Command& command = now().command;
  const double steering = command.steering_rad;
  // The wheel that carries the encoder runs on a circle of its own: inside, it is slower.
  const double wheel_speed =
      command.speed_mps * terrain_.stretch(now().pose) *
      (1.0 - std::tan(steering) * geometry.encoder_offset_left_m / geometry.wheelbase_m);
  const MotionNoise& noise = vehicle_.noise;
  const double speed_error =
      sensor_.noise_scale *
      (noise.speed_deviation_mps * speed_noise_.value() +
       noise.speed_deviation_relative * wheel_speed * relative_speed_noise_.value());
  const double steering_error =
      sensor_.noise_scale *
      (noise.steering_deviation_rad * turn_noise_.value() +
       noise.steering_deviation_relative * steering * relative_turn_noise_.value());
  return {time_s, (wheel_speed - speed_error) / calibration_.speed_scale,
          (steering - calibration_.turn_offset - steering_error) / calibration_.turn_scale};
}

TwistInput SimulatedVehicle::reportTwist(double time_s) const {
  const double yaw_rate = yawRate(now().command, vehicle_.ackermann.wheelbase_m);
  const double speed = now().command.speed_mps * terrain_.stretch(now().pose);
  const MotionNoise& noise = vehicle_.noise;
  const double speed_error =
      sensor_.noise_scale *
      (noise.speed_deviation_mps * speed_noise_.value() +
       noise.speed_deviation_relative * speed * relative_speed_noise_.value());
  const double turn_error =
      sensor_.noise_scale *
      (noise.yaw_rate_deviation_radps * turn_noise_.value() +
       noise.yaw_rate_deviation_relative * yaw_rate * relative_turn_noise_.value());
  return {time_s, (speed - speed_error) / calibration_.speed_scale, 0.0,
          (yaw_rate - calibration_.turn_offset - turn_error) / calibration_.turn_scale};
}

}  // namespace hymm::core
