#pragma once

#include <functional>
#include <optional>
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

/// What a search has found.
struct DuplicatesFound {
  std::vector<DuplicateLandmarks> pairs;
  /// If the vehicle, with what it saw lately, was farther off than the filter claims: covariance of
  /// its pose, to be added (x, y [m], yaw [rad], map axes).
  std::optional<Eigen::Matrix3d> slip;
};

/// Closes loops that no single scan can close. A vehicle that comes back so uncertain that a scan
/// does not tell which old landmarks it sees maps them anew. When enough of the new ones stand to
/// each other as old ones do, jointly and beyond coincidence, they are the same: the covariance
/// between all of them says how well they fit. Where they do not fit by that covariance, but are
/// alike beyond any coincidence once the vehicle may have slipped (SlipConfig), it has.
class DuplicateSearch {
 public:
  DuplicateSearch(const LandmarkConfig& landmarks, const AssociationConfig& association,
                  const SlipConfig& slip);

  /// Whether two landmarks are known to be different objects, by slot.
  using AreDistinct = std::function<bool(int, int)>;

  /// Duplicates among the landmarks around the vehicle. `time_s`: of the present scan. Activates
  /// what it compares.
  DuplicatesFound find(double time_s, const Eigen::Vector2d& vehicle,
                       const AreDistinct& are_distinct, const LandmarkRegistry& registry,
                       CompressedEkf& filter) const;

 private:
  /// A landmark seen lately, and an older one that it may be.
  struct Candidate {
    Pairing pairing;  ///< by number of the recent landmark, and slot of the older one
    DuplicateLandmarks pair;
    double distance2 = 0.0;
  };

  /// Landmarks seen lately, with those that they may be.
  struct Candidates {
    std::vector<Candidate> all;
    int recent = 0;  ///< landmarks that have some
  };

  static std::vector<DuplicateLandmarks> pairsOf(const Candidates& candidates);
  /// Which older landmarks are considered.
  struct Reach {
    double widened;   ///< times that deviations may be greater than the filter claims
    double before_s;  ///< not seen since
  };

  /// `recent`: slots of the landmarks seen lately.
  Candidates candidates(const std::vector<int>& recent, const Reach& reach,
                        const AreDistinct& are_distinct, const LandmarkRegistry& registry,
                        CompressedEkf& filter) const;
  std::vector<int> olderNear(const RegisteredLandmark& recent, double gate, const Reach& reach,
                             const AreDistinct& are_distinct,
                             const LandmarkRegistry& registry) const;
  std::vector<Candidate> candidatesOf(int recent_number, const RegisteredLandmark& recent,
                                      const Reach& reach, const AreDistinct& are_distinct,
                                      const LandmarkRegistry& registry,
                                      CompressedEkf& filter) const;
  DuplicatesFound findAfterSlip(const Candidates& candidates, const Eigen::Vector2d& vehicle,
                                const CompressedEkf& filter) const;
  std::vector<DuplicateLandmarks> choose(const Candidates& candidates, const Eigen::MatrixXd& S,
                                         double least_log_odds) const;

  LandmarkConfig landmarks_;
  AssociationConfig association_;
  SlipConfig slip_;
  double gate_;
  double least_log_odds_;
  JointCompatibility joint_;
};

}  // namespace hymm::core
