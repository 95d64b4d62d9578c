#include "ros/odometry_motion.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>

namespace hymm {
namespace {

constexpr double kFastest_mps = 100.0;  // what seems faster is a pose that was set anew

// A step is believed that departs from all that was told of the velocity by no more than this:
// ticks of encoders, slip, and what a vehicle gains within the step.
constexpr double kStep_m = 0.02;
constexpr double kStep_rad = 0.03;
constexpr double kStep_relative = 0.25;
constexpr double kGain_mps2 = 3.0;
constexpr double kGain_radps2 = 3.0;
constexpr double kLongestGain_s = 1.0;

// Poses that do not change for so much of the twist are not between two ticks of an encoder.
constexpr double kStanding_m = 0.1;
constexpr double kStanding_rad = 0.1;

// The sources are compared each time that one of them has come so far; a twist that is filtered
// lags behind by some of the absolute part.
constexpr double kCompared_m = 5.0;
constexpr double kCompared_rad = 3.0;
constexpr double kLongestCompared_s = 2.0;  // between readings; beyond, the twist tells nothing
constexpr double kContradiction_relative = 0.1;
constexpr double kContradiction_m = 0.1;
constexpr double kContradiction_rad = 0.1;

/// The constant velocity that leads along `moved` in `duration_s`. The chord points half the turn
/// ahead and is shorter than the arc by sin(t/2) / (t/2).
Eigen::Vector3d velocityOf(const core::Pose2& moved, double duration_s) {
  const double half = 0.5 * moved.yaw_rad;
  const double stretch = std::abs(half) < 1e-6 ? 1.0 : half / std::sin(half);
  const Eigen::Vector2d arc = stretch * (Eigen::Rotation2Dd(-half) * moved.position()) / duration_s;
  return {arc.x(), arc.y(), moved.yaw_rad / duration_s};
}

std::string textOf(const Eigen::Vector3d& moved) {
  std::ostringstream text;
  text.precision(3);
  text << moved.x() << " m ahead, " << moved.y() << " m to the left and " << moved.z()
       << " rad of turn";
  return text.str();
}

}  // namespace

void OdometryMotion::Course::add(const Eigen::Vector3d& velocity, double duration_s) {
  moved += velocity * duration_s;
  distance_m += velocity.head<2>().norm() * duration_s;
  turn_rad += std::abs(velocity.z()) * duration_s;
}

std::optional<core::TwistInput> OdometryMotion::take(const OdometryReading& now, CauseLog& causes) {
  if (!now.T_odom_base && !now.twist) {
    causes.count("odometry refused",
                 "An odometry message has neither a twist nor a pose that is finite; it is not "
                 "used.");
    return std::nullopt;
  }
  if (!now.twist) {
    causes.count("odometry whose twist is not finite",
                 "The twist of odometry is not finite; its poses are used.");
  }
  const std::optional<OdometryReading> before = readingBefore(now);
  if (!before) return std::nullopt;
  const Step step = stepTo(now, *before);
  velocity_ = choose(step, *before, now, causes);
  pose_velocity_ = step.by_poses;
  if (!velocity_) return std::nullopt;
  const Eigen::Vector3d& v = *velocity_;
  return core::TwistInput{step.begin_s, v.x(), v.y(), v.z(), std::nullopt, step.end_s};
}

/// The one that time goes on from. A message with an earlier stamp than the newest is stray unless
/// another goes on from it: then the clock was put back.
std::optional<OdometryReading> OdometryMotion::readingBefore(const OdometryReading& now) {
  if (!last_ || now.time_s > last_->time_s) {
    older_.reset();
    return std::exchange(last_, now);
  }
  if (!older_ || now.time_s <= older_->time_s) {
    older_ = now;
    return std::nullopt;
  }
  velocity_.reset();
  pose_velocity_.reset();
  last_ = now;
  return std::exchange(older_, std::nullopt);
}

OdometryMotion::Step OdometryMotion::stepTo(const OdometryReading& now,
                                            const OdometryReading& before) const {
  Step step{before.time_s, now.time_s, std::nullopt, std::nullopt, Eigen::Vector3d::Zero()};
  if (before.T_odom_base && now.T_odom_base) {
    step.by_poses =
        velocityOf(core::inverse(*before.T_odom_base) * *now.T_odom_base, step.duration_s());
  }
  // Right of velocities of one moment, and half an interval late of means over the one before it.
  if (before.twist && now.twist) {
    step.by_twist = 0.5 * (*before.twist + *now.twist);
    step.gained = *now.twist - *before.twist;
  } else if (now.twist) {
    step.by_twist = now.twist;
  }
  return step;
}

std::optional<Eigen::Vector3d> OdometryMotion::choose(const Step& step,
                                                      const OdometryReading& before,
                                                      const OdometryReading& now,
                                                      CauseLog& causes) {
  has_twist_ = has_twist_ || (step.by_twist && !step.by_twist->isZero(0.0));
  if (!step.by_poses) return step.by_twist;
  if (before.T_odom_base->vector() == now.T_odom_base->vector()) return whileStanding(step, causes);
  has_moved_ = true;
  standing_ = Course();
  if (!has_twist_ && now.twist) {
    causes.count("odometry without twist",
                 "The poses of odometry move but its twist is zero; poses are used for it.");
  }
  if (!isSetAnew(step, before, now)) {
    compare(step, causes);
    return step.by_poses;
  }
  causes.count("odometry set anew",
               "The pose of odometry jumps; that is no motion, and its twist or the velocity "
               "before it is used for that step.");
  return has_twist_ && step.by_twist && !contradicts_ ? step.by_twist : velocity_;
}

/// Poses that do not change: there are none, or the vehicle stands, or they come in ticks, or
/// their source has lost its way.
std::optional<Eigen::Vector3d> OdometryMotion::whileStanding(const Step& step, CauseLog& causes) {
  if (!step.by_twist || step.by_twist->isZero(0.0) || contradicts_) return step.by_poses;
  if (!has_moved_) return step.by_twist;
  standing_.add(*step.by_twist, step.duration_s());
  if (standing_.distance_m < kStanding_m && standing_.turn_rad < kStanding_rad) {
    return step.by_poses;
  }
  causes.count("odometry whose poses stand still",
               "The poses of odometry stand still while its twist moves; the twist is used "
               "until they move again.");
  return step.by_twist;
}

bool OdometryMotion::isSetAnew(const Step& step, const OdometryReading& before,
                               const OdometryReading& now) const {
  const Eigen::Vector3d& v = *step.by_poses;
  if (v.head<2>().norm() > kFastest_mps) return true;
  if (!velocity_) return false;  // nothing to compare with
  Eigen::Array3d lowest = *velocity_, highest = *velocity_;
  const auto explain = [&](const std::optional<Eigen::Vector3d>& told) {
    if (!told) return;
    lowest = lowest.min(told->array());
    highest = highest.max(told->array());
  };
  explain(pose_velocity_);
  if (has_twist_) {
    explain(before.twist);
    explain(now.twist);
  }
  const Eigen::Array3d reach = lowest.abs().max(highest.abs());
  const double gain_s = std::min(step.duration_s(), kLongestGain_s);
  const double speed_mps = kStep_m / step.duration_s() +
                           kStep_relative * std::max(reach.x(), reach.y()) + kGain_mps2 * gain_s;
  const double rate_radps =
      kStep_rad / step.duration_s() + kStep_relative * reach.z() + kGain_radps2 * gain_s;
  const Eigen::Array3d margin(speed_mps, speed_mps, rate_radps);
  return (v.array() > highest + margin || v.array() < lowest - margin).any();
}

void OdometryMotion::compare(const Step& step, CauseLog& causes) {
  if (!has_twist_ || !step.by_twist || step.duration_s() > kLongestCompared_s) return;
  poses_.add(*step.by_poses, step.duration_s());
  twists_.add(*step.by_twist, step.duration_s());
  unsure_.add(0.5 * step.gained, step.duration_s());
  const double distance_m = std::max(poses_.distance_m, twists_.distance_m);
  const double turn_rad = std::max(poses_.turn_rad, twists_.turn_rad);
  if (distance_m < kCompared_m && turn_rad < kCompared_rad) return;
  const Eigen::Vector3d apart = poses_.moved - twists_.moved;
  contradicts_ = apart.head<2>().norm() >
                     kContradiction_relative * distance_m + kContradiction_m + unsure_.distance_m ||
                 std::abs(apart.z()) >
                     kContradiction_relative * turn_rad + kContradiction_rad + unsure_.turn_rad;
  if (contradicts_) {
    causes.count("odometry whose twist contradicts its poses",
                 "The poses of odometry tell of " + textOf(poses_.moved) +
                     " where its twist tells of " + textOf(twists_.moved) +
                     " (along the vehicle's axes); the poses are used. Its twist should be in "
                     "child_frame_id, in m/s and rad/s.");
  }
  poses_ = twists_ = unsure_ = Course();
}

}  // namespace hymm
