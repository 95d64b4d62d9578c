#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/pose2.h"
#include "ros/cause_log.h"
#include "vehicle/motion_input.h"

namespace hymm {

/// What a message of odometry tells of base_link.
struct OdometryReading {
  double time_s = 0.0;
  std::optional<core::Pose2> T_odom_base;
  std::optional<Eigen::Vector3d> twist;  ///< (forward, lateral, yaw rate)
};

/// Readings of odometry to motion: of two readings, the velocity that led from one to the other.
/// Two poses say that whatever the driver means by a twist: of one moment or a mean, of whose axes
/// and in which units. The twist counts
/// - where no poses are given, or they stand still while it moves;
/// - where a pose is set anew: one step that neither the velocities before it nor the twist
/// explain. Where poses and twist contradict each other over a distance, that is counted among the
/// causes.
class OdometryMotion {
 public:
  /// Nothing where there is no earlier reading, or nothing to go by.
  std::optional<core::TwistInput> take(const OdometryReading& now, CauseLog& causes);

  /// Another recording begins.
  void reset() { *this = OdometryMotion(); }

 private:
  /// What both sources tell of the time from one reading to the next.
  struct Step {
    double begin_s, end_s;
    std::optional<Eigen::Vector3d> by_poses;
    std::optional<Eigen::Vector3d> by_twist;
    Eigen::Vector3d gained = Eigen::Vector3d::Zero();  ///< of the twist
    double duration_s() const { return end_s - begin_s; }
  };

  /// Sums since the sources were last compared: along the vehicle's axes, and of amounts.
  struct Course {
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    double distance_m = 0.0, turn_rad = 0.0;
    void add(const Eigen::Vector3d& velocity, double duration_s);
  };

  std::optional<OdometryReading> readingBefore(const OdometryReading& now);
  Step stepTo(const OdometryReading& now, const OdometryReading& before) const;
  std::optional<Eigen::Vector3d> choose(const Step& step, const OdometryReading& before,
                                        const OdometryReading& now, CauseLog& causes);
  std::optional<Eigen::Vector3d> whileStanding(const Step& step, CauseLog& causes);
  bool isSetAnew(const Step& step, const OdometryReading& before, const OdometryReading& now) const;
  void compare(const Step& step, CauseLog& causes);

  std::optional<OdometryReading> last_;
  std::optional<OdometryReading> older_;     ///< came after last_ with a stamp not later than its
  bool has_twist_ = false;                   ///< one that was not zero
  bool has_moved_ = false;                   ///< a pose differed from the one before
  Course standing_;                          ///< of the twist, since the poses stand still
  std::optional<Eigen::Vector3d> velocity_;  ///< used last
  std::optional<Eigen::Vector3d> pose_velocity_;  ///< of the last two poses
  Course poses_, twists_;
  Course unsure_;             ///< how far the twists may be off for what they were between readings
  bool contradicts_ = false;  ///< the twist, as far as was compared last
};

}  // namespace hymm
