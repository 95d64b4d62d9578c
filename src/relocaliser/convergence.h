#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/config.h"
#include "relocaliser/density_map.h"
#include "relocaliser/local_map.h"
#include "relocaliser/particle_modes.h"

namespace hymm::core {

/// When the relocaliser believes itself.
struct ConvergenceConfig {
  double propagation_factor = 2.0;  ///< times the motion's noise over one second (A.4)
  double information_factor = 1.5;  ///< times what one scan at that place can tell
  double least_mode_share = 0.999;  ///< of the weight
  double least_explained = 0.6;     ///< share of the observations, over the scans held
  double most_missed = 0.5;         ///< share of the landmarks that should have been seen
  int least_landmarks = 3;          ///< that explain observations
  double gate_probability = 0.99;   ///< of an observation and the landmark that explains it
  int hold_scans = 3;               ///< in a row for which all this holds
  double hold_way_m = 1.0;          ///< driven meanwhile
  double rival_margin = 12.0;       ///< log likelihood by which every other place has to be worse

  void describe(ConfigSchema& schema);
};

/// How well one pose explains one scan.
struct Explanation {
  int observations = 0;
  int explained = 0;  ///< observations near enough to a landmark
  int landmarks = 0;  ///< different ones that explain
  int expected = 0;   ///< landmarks well within range and field of view
  int missed = 0;     ///< of those, that no observation is near to
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the pose, by what is explained
};

/// What the sensor can see, as seen from it.
struct SensorView {
  Pose2 T_base_sensor;
  double range_m = 25.0;  ///< in which landmarks are expected to be seen
  double field_of_view_rad = kPi;
};

Explanation explainScan(const Pose2& T_local_base, const Eigen::Matrix3d& covariance,
                        const std::vector<ObservedPoint>& points,
                        const std::vector<LocalLandmark>& landmarks, const SensorView& view,
                        double gate_probability);

/// Deviations (x, y [m], yaw [rad]) below which the particles count as converged: the greater of
/// `propagation_factor` times the motion's noise and `information_factor` times the deviations that
/// the information of one scan leaves. `T_local_base` turns the first into local axes.
Eigen::Vector3d convergedDeviations(const Pose2& T_local_base,
                                    const Eigen::Vector3d& motion_deviation,
                                    const Eigen::Matrix3d& information,
                                    const ConvergenceConfig& config);

/// Why a mode is not to be believed yet; empty if it is.
std::string findDoubt(const std::vector<ParticleMode>& modes, const Explanation& explanation,
                      const Eigen::Vector3d& limit, const ConvergenceConfig& config);

}  // namespace hymm::core
