#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <tf2/buffer_core.h>

#include "common/pose2.h"

namespace hymm {

/// Where sensors stand on the vehicle, by the frame of their messages: from tf, asked for until it
/// answers, then remembered. A sensor is never taken to stand at the vehicle's origin for want of
/// knowledge.
class SensorMountings {
 public:
  struct Answer {
    std::optional<core::Pose2> T_base_sensor;
    /// Its z axis points down: angles about it count clockwise seen from above. T_base_sensor is of
    /// its x axis all the same.
    bool upside_down = false;
    bool waiting = false;  ///< not known yet; ask again
    std::string problem;   ///< where it is neither: why, and what to do
    std::string assumed;   ///< where T_base_sensor is the vehicle's description: why, and which
    Eigen::Isometry3d T_base_frame = Eigen::Isometry3d::Identity();  ///< of findInSpace()
  };

  /// `fallback`: from the vehicle's description, if it tells; used, and told in the answer, when tf
  /// has not answered within `wait_s` of the first question.
  SensorMountings(const tf2::BufferCore& tf, std::string base_frame,
                  std::optional<core::Pose2> fallback, double wait_s);

  /// `steady_now_s`: any clock that runs with the wall and never jumps.
  Answer find(const std::string& sensor_frame, double steady_now_s);

  /// The same of a sensor that measures in space: it may be tilted, and how high it stands counts,
  /// so that only tf can tell.
  Answer findInSpace(const std::string& sensor_frame, double steady_now_s);

  /// As the vehicle's description has it.
  const std::string& baseFrame() const { return base_frame_; }

  /// Forgets what tf said: another recording begins.
  void reset();

 private:
  struct Entry {
    double first_asked_s = 0.0;
    Answer answer;
  };

  Answer remembered(const std::string& sensor_frame, bool in_space, double steady_now_s);
  Answer ask(const std::string& sensor_frame, bool in_space, double waited_s) const;

  const tf2::BufferCore& tf_;
  std::string base_frame_;
  std::optional<core::Pose2> fallback_;
  double wait_s_;
  std::map<std::pair<std::string, bool>, Entry> entries_;  ///< by frame, and whether in space
};

}  // namespace hymm
