#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "perception/observation.h"

namespace hymm::core {

struct TentativeConfig {
  int sightings = 3;    ///< that promote a tentative landmark, at least
  double share = 0.3;   ///< of the scans from its first sighting on that must show it
  double span_s = 1.0;  ///< least time between the first and the last sighting
  double gate_m = 0.2;  ///< added to the measurement's own 3 deviations, for the pose's change
};

/// Objects seen but not yet trusted to be landmarks, at whatever rate the sensor scans. They live
/// outside the filter's state, so that people who walk and cars that turn never enter it; the scan
/// that promotes one is the only one whose measurement the filter uses.
class TentativeLandmarks {
 public:
  explicit TentativeLandmarks(const TentativeConfig& config);

  /// A sighting at `position` (map frame, covariance of the measurement alone) in scan number
  /// `scan` at `time_s`. It belongs to a tentative landmark that was first seen at this very place,
  /// not to one that has come here. True if it promotes that one, which is then forgotten;
  /// `at_once`: without waiting for the time span.
  bool observe(const Eigen::Vector2d& position, const Eigen::Matrix2d& covariance,
               LandmarkType type, long scan, double time_s, bool at_once = false);

  /// Forgets what is not seen often enough.
  void expire(long scan);
  void clear() { candidates_.clear(); }
  std::size_t size() const { return candidates_.size(); }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(candidates_);
  }

 private:
  struct Sighting {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    std::int64_t scan = 0;
    double time_s = 0.0;

    template <class Archive>
    void describeState(Archive& archive) {
      archive(position, scan, time_s);
    }
  };
  struct Candidate {
    LandmarkType type = LandmarkType::kUnknown;
    std::vector<Sighting> sightings;  ///< in order; never empty

    template <class Archive>
    void describeState(Archive& archive) {
      archive(type, sightings);
      if constexpr (Archive::kReads) {
        archive.require(!sightings.empty(), "a tentative landmark was never seen");
      }
    }
  };

  /// Forgets its first sightings until the rest are frequent enough up to scan number `scan`.
  void forgetInfrequent(Candidate& candidate, long scan) const;
  Candidate* nearest(const Eigen::Vector2d& position, double radius_m, LandmarkType type,
                     long scan);

  TentativeConfig config_;
  std::vector<Candidate> candidates_;
};

}  // namespace hymm::core
