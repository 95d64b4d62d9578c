#pragma once

#include <Eigen/Core>

#include "vehicle/motion_input.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// What speed and turn were read a while ago, smoothed. From these a filter learns the scales of
/// the readings: true = scale * read + error, and what is read holds the error itself. On a
/// straight way the steering read is nothing but its error, and where landmarks show that the car
/// did not turn, a scale below one seems to say so (errors in variables; attenuation). Earlier
/// readings tell as well how the car drives, and their errors are others by now: an instrumental
/// variable.
///
/// Two first-order lags in a row for each reading, of three correlation times of its error each. Of
/// the bias a sixteenth is left.
class EarlierReadings {
 public:
  explicit EarlierReadings(const MotionNoise& noise);

  /// As of the present time.
  MotionReadings readings() const { return MotionReadings::fromVector(delayed_); }
  /// `input` has held for ever.
  void begin(const MotionInput& input);
  /// `input` has held for `duration_s` [s].
  void follow(const MotionInput& input, double duration_s);

  template <class Archive>
  void describeState(Archive& archive) {
    archive(smoothed_, delayed_);
  }

 private:
  Eigen::Array3d lag_s_;  ///< of one of the two
  Eigen::Vector3d smoothed_ = Eigen::Vector3d::Zero(), delayed_ = Eigen::Vector3d::Zero();
};

}  // namespace hymm::core
