#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "common/pose2.h"
#include "evaluation/error_statistics.h"
#include "evaluation/trajectory.h"

namespace hymm::core {

/// How estimated landmarks compare with true ones.
struct LandmarkErrors {
  ErrorStatistics distance_m;          ///< of the matched, in the frame they were given in
  ErrorStatistics aligned_distance_m;  ///< of the matched, after the alignment
  Consistency nees;                    ///< of the matched, before the alignment, two dof each
  std::size_t false_landmarks = 0;     ///< estimated, but none is there, or another is matched
  std::size_t duplicates = 0;          ///< of these: within the gate of one that another has
  std::size_t missed = 0;        ///< there and within `missed_range_m` of a pose, but not estimated
  std::size_t out_of_range = 0;  ///< neither matched nor within range: not expected
  Pose2 T_truth_map;             ///< the alignment, from the matched
};

struct LandmarkMatching {
  Pose2 T_truth_map;  ///< from the map into the truth's frame, as given: errors count in it
  /// Where else the search for partners may begin: a map that turned early lies metres off at its
  /// far end, though it is right in itself.
  std::vector<Pose2> other_guesses;
  double gate_m = 1.0;           ///< longest distance of a match, after the alignment
  double missed_range_m = 20.0;  ///< from a pose, within which a landmark should have been found
};

/// Matches estimated landmarks with true ones, each at most once, nearest pairs first, and aligns
/// the matched by one rigid motion; both in turn until the matches stay. Of the guesses where this
/// may begin the one with the most matches counts. Nothing if no landmark is matched.
std::optional<LandmarkErrors> computeLandmarkErrors(const std::vector<LandmarkEstimate>& estimates,
                                                    const std::vector<Eigen::Vector2d>& truth,
                                                    const std::vector<StampedPose>& poses,
                                                    const LandmarkMatching& matching);

}  // namespace hymm::core
