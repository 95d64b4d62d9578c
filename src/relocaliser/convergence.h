#pragma once

#include <map>
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
  double most_absent = 0.2;         ///< landmarks that are never seen, for each that mostly is
  int least_landmarks = 3;          ///< that explain observations
  double gate_probability = 0.99;   ///< of an observation and the landmark that explains it
  double hold_s = 0.8;              ///< for which all this holds, scan after scan
  double hold_way_m = 8.0;          ///< driven meanwhile
  double rival_margin = 12.0;       ///< log likelihood by which every other place has to be worse

  /// Scans nearer to each other count as one: they show the same from the same place.
  double holdSpacing_s() const { return 0.25 * hold_s; }
  void describe(ConfigSchema& schema);
};

/// How well one pose explains one scan.
struct Explanation {
  int observations = 0;
  int explained = 0;        ///< observations near enough to a landmark
  std::vector<int> seen;    ///< ids of the landmarks that explain
  std::vector<int> missed;  ///< of those well within range and field of view that do not
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();   ///< of the pose, by what is explained
  Eigen::Matrix3d of_points = Eigen::Matrix3d::Zero();     ///< the same, were the landmarks exact
  Eigen::Matrix3d of_landmarks = Eigen::Matrix3d::Zero();  ///< the same, were the points exact

  int landmarks() const { return static_cast<int>(seen.size()); }
};

/// What speaks for one mode, scan by scan, for as long as nothing speaks against it.
class HeldEvidence {
 public:
  /// Scans nearer to the one before count for their time and way only.
  explicit HeldEvidence(double spacing_s) : spacing_s_(spacing_s) {}

  void clear();
  /// In order of time.
  void add(double time_s, const Explanation& explanation, double way_m);
  /// All that were added.
  int scans() const { return scans_; }
  double lasting_s() const { return last_s_ - first_s_; }
  double way_m() const { return way_m_; }
  double explainedShare() const;
  /// Landmarks that were seen in most of the scans that should show them.
  int present() const;
  /// Landmarks that several scans should have shown, and none did. By chance one is missed in a
  /// scan; where the same ones are missed again and again, this is another place.
  int absent() const;

 private:
  struct Tally {
    int seen = 0;
    int missed = 0;
  };

  double spacing_s_;
  int scans_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
  double counted_s_ = 0.0;  ///< the last scan that counts
  double way_m_ = 0.0;
  int observations_ = 0;
  int explained_ = 0;
  std::map<int, Tally> landmarks_;
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

/// Why a mode does not explain this scan; empty if it does.
std::string findDoubt(const std::vector<ParticleMode>& modes, const Explanation& explanation,
                      const Eigen::Vector3d& limit, const ConvergenceConfig& config);

/// Why what was held is not enough yet; empty if it is.
std::string findDoubt(const HeldEvidence& evidence, const ConvergenceConfig& config);

}  // namespace hymm::core
