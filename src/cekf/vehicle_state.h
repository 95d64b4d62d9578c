#pragma once

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "cekf/accumulated_noise.h"
#include "cekf/compressed_ekf.h"
#include "cekf/motion_noise_scale.h"
#include "cekf/observation_model.h"
#include "vehicle/earlier_readings.h"
#include "vehicle/motion_model.h"
#include "vehicle/sweep_motion.h"

namespace hymm::core {

class StateReader;
class StateWriter;

/// Systematic errors of the laser, as (yaw of its mounting [rad], by how much its ranges are too
/// long [m], time of measuring after the stamp [s]).
struct LaserCalibration {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();
};

/// The vehicle's part of the filter's state: pose (x, y, yaw), the present errors of the motion
/// input (speed, turn; in units of their deviations), those calibration values that are estimated,
/// and where east and north lie in the map if GPS is fused. Carries it along the motion.
class VehicleState {
 public:
  /// `twist` says which of the vehicle's calibration priors concern the turn. `at_first_estimates`:
  /// the Jacobian of the motion leads from where the vehicle was predicted before, not from where
  /// it was corrected to since.
  VehicleState(const VehicleConfig& vehicle, bool twist, bool with_gps_datum,
               bool at_first_estimates = false, const MotionNoiseConfig& motion_noise = {});

  int size() const { return size_; }
  /// First of the three states (x, y, yaw) of T_map_enu, or -1.
  int gpsDatumIndex() const { return gps_datum_index_; }
  Eigen::VectorXd initialState() const;
  Eigen::MatrixXd initialCovariance() const;

  /// A sensor mounted at `T_base_sensor`, with its errors of yaw, range and time as among `state`.
  SensorPlacement placement(const Pose2& T_base_sensor, const VehicleVector& state) const;

  /// How the vehicle moves on from the present time: by the input in force, then by `inputs`, each
  /// of which holds until the next. Still if there has been no input.
  SweepMotion motionFrom(const CompressedEkf& filter, const std::vector<MotionInput>& inputs) const;

  static Pose2 pose(const CompressedEkf& filter) {
    return Pose2::fromVector(filter.vehicle().head<3>());
  }
  Calibration calibration(const VehicleVector& state) const;
  MotionError motionError(const VehicleVector& state) const;
  /// Errors of the laser as estimated; what is not estimated is zero.
  LaserCalibration laserCalibration(const CompressedEkf& filter) const;
  /// Covariance of (speed scale, turn scale, turn offset); zero for what is not estimated.
  Eigen::Matrix3d calibrationCovariance(const VehicleMatrix& vehicle_covariance) const;

  /// Moves the filter to `time_s` with the input in force, then puts `input` in force. False, and
  /// nothing changes, if the input is not finite or not later than the last.
  bool takeInput(CompressedEkf& filter, const MotionInput& input);

  /// Moves the filter to `time_s` with the input in force, as standing still before the first.
  void moveTo(CompressedEkf& filter, double time_s);

  /// The position that the covariance belongs to where Jacobians are taken at first estimates:
  /// where the last motion has put the vehicle, whatever was measured since. See relinearise().
  const Eigen::Vector2d& linearisedAt() const { return linearised_at_; }
  void linearisePositionAt(const Eigen::Vector2d& position) { linearised_at_ = position; }

  /// Covariance that the motion's noise alone has given the vehicle's states since the last
  /// beginMotionNoise(), at which the errors of the input were anything.
  VehicleMatrix motionNoise() const { return motion_noise_.total(size_); }
  void beginMotionNoise();
  /// The noise since then was that many times as large.
  void multiplyMotionNoise(double factor) { motion_noise_.multiply(factor); }
  /// Learns from an update how large the noise since then is.
  void learnMotionNoise(const UpdateOutcome& update);
  /// How much larger the noise is than claimed.
  const MotionNoiseScale& noiseScale() const { return noise_scale_; }

  bool hasInput() const { return has_input_; }
  double time_s() const { return time_s_; }
  std::size_t gaps() const { return gaps_; }
  /// How long an input holds [s].
  double holdLimit_s() const { return hold_limit_s_; }

  /// The next event's time is the present one: the vehicle has stood still since the last.
  void restartClock() {
    started_ = has_input_ = in_gap_ = false;
    time_s_ = -std::numeric_limits<double>::infinity();
  }

  void save(StateWriter& archive);
  /// Throws InputError if other quantities were estimated.
  void restore(StateReader& archive);

 private:
  template <class Archive>
  void describeState(Archive& archive);
  void predict(CompressedEkf& filter, double age_s, double duration_s);
  VehicleMatrix addNoise(const MotionStep& step, const VehicleMatrix& J);
  AccumulatedNoise::Parts errorVariances() const;
  Eigen::Vector3d noiseTimes() const;
  Eigen::Matrix3d velocityCovariance(const BodyVelocity& velocity,
                                     const VehicleMatrix& covariance) const;

  /// Errors of the laser; the index is -1 for what is not estimated.
  struct LaserError {
    int index = -1;
    double deviation = 0.0;  ///< of the prior

    double valueIn(const VehicleVector& state) const { return index >= 0 ? state[index] : 0.0; }
  };

  MotionModel model_;
  EarlierReadings earlier_readings_;
  double hold_limit_s_;
  std::array<int, 3> calibration_index_{-1, -1, -1};
  std::array<double, 3> calibration_deviation_{0.0, 0.0, 0.0};
  LaserError laser_yaw_, laser_range_, laser_time_;
  int gps_datum_index_ = -1;
  static constexpr int kErrorIndex = 3;  ///< of the speed's error, then the turn's
  int turn_relative_index_ = -1;         ///< of the turn's relative error, if there is such a part
  int size_ = 5;

  bool at_first_estimates_;
  Eigen::Vector2d linearised_at_ = Eigen::Vector2d::Zero();
  AccumulatedNoise motion_noise_;
  MotionNoiseScale noise_scale_;
  MotionInput input_ = TwistInput{};
  bool has_input_ = false;
  bool started_ = false;
  bool in_gap_ = false;
  double time_s_ = -std::numeric_limits<double>::infinity();
  std::size_t gaps_ = 0;
};

}  // namespace hymm::core
