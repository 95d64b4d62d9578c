#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "cekf/joint_compatibility.h"
#include "cekf/landmark_registry.h"

namespace hymm::core {

/// Two landmarks that are one object, by slot.
struct DuplicateLandmarks {
  int kept = -1;  ///< the older one
  int gone = -1;
};

/// Closes loops that no single scan can close. A vehicle that comes back so uncertain that a scan
/// does not tell which old landmarks it sees maps them anew. When enough of the new ones stand to
/// each other as old ones do, jointly and beyond coincidence, they are the same: the covariance
/// between all of them says how well they fit.
class DuplicateSearch {
 public:
  DuplicateSearch(const LandmarkConfig& landmarks, const AssociationConfig& association);

  /// Whether two landmarks are known to be different objects, by slot.
  using AreDistinct = std::function<bool(int, int)>;

  /// Duplicates among the landmarks around the vehicle. `time_s`: of the present scan. Activates
  /// what it compares.
  std::vector<DuplicateLandmarks> find(double time_s, const Eigen::Vector2d& vehicle,
                                       const AreDistinct& are_distinct,
                                       const LandmarkRegistry& registry,
                                       CompressedEkf& filter) const;

 private:
  /// A landmark seen lately, and an older one that it may be.
  struct Candidate {
    Pairing pairing;  ///< by number of the recent landmark, and slot of the older one
    DuplicateLandmarks pair;
    double distance2 = 0.0;
  };

  std::vector<Candidate> candidatesOf(int recent_number, const RegisteredLandmark& recent,
                                      const AreDistinct& are_distinct,
                                      const LandmarkRegistry& registry,
                                      CompressedEkf& filter) const;
  std::vector<DuplicateLandmarks> choose(const std::vector<Candidate>& candidates, int recent,
                                         const CompressedEkf& filter) const;

  LandmarkConfig landmarks_;
  AssociationConfig association_;
  double gate_;
  double least_log_odds_;
  JointCompatibility joint_;
};

}  // namespace hymm::core
