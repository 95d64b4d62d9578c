#pragma once

#include <vector>

#include <Eigen/Core>

#include "perception/observation.h"

namespace hymm::core {

struct TentativeConfig {
  int sightings = 3;     ///< that promote a tentative landmark
  int within_scans = 6;  ///< in which they must happen
  double gate_m = 0.5;   ///< added to the measurement's own 3 deviations, for the pose's change
};

/// Objects seen but not yet trusted to be landmarks. They live outside the filter's state, so that
/// people who walk and cars that turn never enter it; the scan that promotes one is the only one
/// whose measurement the filter uses.
class TentativeLandmarks {
 public:
  explicit TentativeLandmarks(const TentativeConfig& config);

  /// A sighting at `position` (map frame, covariance of the measurement alone) in scan number
  /// `scan`. True if it promotes the tentative landmark it belongs to, which is then forgotten.
  bool observe(const Eigen::Vector2d& position, const Eigen::Matrix2d& covariance,
               LandmarkType type, long scan);

  /// Forgets what was not seen often enough.
  void expire(long scan);
  void clear() { candidates_.clear(); }
  std::size_t size() const { return candidates_.size(); }

 private:
  struct Candidate {
    Eigen::Vector2d position;
    LandmarkType type;
    std::vector<long> scans;
  };

  Candidate* nearest(const Eigen::Vector2d& position, double radius_m, LandmarkType type,
                     long scan);

  TentativeConfig config_;
  std::vector<Candidate> candidates_;
};

}  // namespace hymm::core
