#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "information_map/certain_visibility.h"
#include "information_map/information_config.h"
#include "information_map/information_measure.h"
#include "information_map/landmark_field.h"

namespace hymm::core {

/// What a sensor learns at least about its pose by looking at the landmarks once.
struct AchievableInformation {
  /// (29), on the sensor's pose (x [m], y [m], heading [rad]) in map axes.
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  double value = 0.0;        ///< i(X) (20): the measure of it [1/m^2]
  double heading_rad = 0.0;  ///< of the sensor; 0 where none is chosen (omnidirectional)
  int landmarks = 0;         ///< that it comes from
  /// By how much [m] the regions of landmarks around can move or grow before another set of them is
  /// visible for certain, at most kLargestMargin_m. 0 where a field of view or occlusion decides.
  double margin_m = 0.0;

  static constexpr double kLargestMargin_m = 2.0;
};

/// Evaluates the achievable information i(X), paper IV-C and IV-E: of the landmarks visible for
/// certain at a pose of the sensor, with their joint covariance.
///
/// Where the map does not tell the covariance of two visible landmarks, the farther one is left
/// out: information from some of the landmarks never exceeds that from all of them, whatever their
/// covariance, so the result stays a lower bound. For the same reason no more than kMostLandmarks
/// of those in view count, the nearest in each direction: the time grows with the cube of their
/// number.
///
/// Reuses its buffers: one object a thread.
class InformationEvaluator {
 public:
  static constexpr std::size_t kMostLandmarks = 60;

  /// Whether something solid hides a landmark from the sensor.
  using Occlusion = std::function<bool(const Eigen::Vector2d& sensor, const Eigen::Vector2d& to)>;

  /// Counts since construction.
  struct Counts {
    std::size_t evaluations = 0;  ///< of i(X): one a place, whatever the heading policy
    std::size_t left_out = 0;     ///< visible landmarks, for want of a covariance
    std::size_t unusable = 0;     ///< joint covariances that are not positive semi-definite
  };

  /// Throws ConfigError for an unknown measure or heading.
  explicit InformationEvaluator(const InformationConfig& config, Occlusion hides = nullptr);

  /// At a place of the sensor, its heading as configured.
  AchievableInformation at(const LandmarkField& field, const Eigen::Vector2d& place);

  /// At a pose of the sensor, with its field of view.
  AchievableInformation at(const LandmarkField& field, const Pose2& T_map_sensor);

  const InformationMeasure& measure() const { return measure_; }
  const Counts& counts() const { return counts_; }

 private:
  enum class Heading { kOmnidirectional, kWorst, kBest, kFixed };
  struct Visible {
    int index = -1;
    Eigen::Vector2d offset;  ///< from the sensor [m]
    RegionView view;
  };
  /// An end of the headings at which a landmark is in the field of view.
  struct Event {
    double heading_rad = 0.0;
    bool enters = false;
  };

  double gather(const LandmarkField& field, const Eigen::Vector2d& place);
  void keepInField(double heading_rad);
  void keepMost(std::size_t most);
  void assembleCovariance(const LandmarkField& field);
  AchievableInformation ofHeading(double heading_rad);
  AchievableInformation ofExtremeHeading(bool best);
  AchievableInformation ofSubset();
  void leaveOutUnknownPairs();
  bool isInField(const RegionView& view, double heading_rad) const;

  InformationConfig config_;
  Occlusion hides_;
  InformationMeasure measure_;
  Heading heading_;
  Counts counts_;

  std::vector<Visible> visible_;                    ///< nearest first
  std::vector<std::pair<int, std::size_t>> turns_;  ///< in its direction, and place in visible_
  std::vector<int> slot_;           ///< place in visible_ by landmark, -1 for others
  std::vector<double> covariance_;  ///< P_L (32), 2n x 2n, lower triangle
  std::vector<char> known_;         ///< n x n: whether the covariance of two is told
  bool all_known_ = true;
  std::vector<int> subset_;   ///< of visible_, nearest first
  std::vector<double> work_;  ///< R (31), then its Cholesky factor
  std::vector<Event> events_;
};

}  // namespace hymm::core
