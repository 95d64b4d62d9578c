#include "evaluation/landmark_error.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>

#include "evaluation/rigid_alignment.h"

namespace hymm::core {
namespace {

using Positions = std::vector<Eigen::Vector2d>;
using Match = std::pair<std::size_t, std::size_t>;  // estimate, truth

constexpr int kMostRounds = 30;

/// Pairs within the gate, nearest first, each landmark at most once; sorted by estimate.
std::vector<Match> match(const Positions& estimates, const Positions& truth, double gate_m) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> candidates;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    for (std::size_t j = 0; j < truth.size(); ++j) {
      const double distance_m = (estimates[i] - truth[j]).norm();
      if (distance_m <= gate_m) candidates.emplace_back(distance_m, i, j);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> estimate_used(estimates.size()), truth_used(truth.size());
  std::vector<Match> matches;
  for (const auto& [distance_m, i, j] : candidates) {
    if (estimate_used[i] || truth_used[j]) continue;
    estimate_used[i] = truth_used[j] = true;
    matches.emplace_back(i, j);
  }
  std::sort(matches.begin(), matches.end());
  return matches;
}

Positions transformed(const Pose2& T, const Positions& positions) {
  Positions moved;
  moved.reserve(positions.size());
  for (const Eigen::Vector2d& p : positions) moved.push_back(T * p);
  return moved;
}

Pose2 align(const std::vector<Match>& matches, const Positions& estimates, const Positions& truth) {
  RigidAlignment alignment;
  for (const auto& [i, j] : matches) alignment.add(estimates[i], truth[j]);
  return alignment.T_to_from();
}

/// Distances of matched pairs after `T_truth_map`.
std::vector<double> distances(const std::vector<Match>& matches, const Pose2& T_truth_map,
                              const Positions& estimates, const Positions& truth) {
  std::vector<double> lengths;
  lengths.reserve(matches.size());
  for (const auto& [i, j] : matches) {
    lengths.push_back((T_truth_map * estimates[i] - truth[j]).norm());
  }
  return lengths;
}

bool isWithin(const Eigen::Vector2d& p, const std::vector<StampedPose>& poses, const Pose2& T,
              double range_m) {
  return std::any_of(poses.begin(), poses.end(), [&](const StampedPose& pose) {
    return (T * pose.pose.position() - p).norm() <= range_m;
  });
}

struct Matching {
  std::vector<Match> matches;
  Pose2 T_truth_map;
};

Matching matchFrom(const Pose2& guess, const Positions& estimates, const Positions& truth,
                   double gate_m) {
  Matching now{match(transformed(guess, estimates), truth, gate_m), guess};
  for (int round = 0; round < kMostRounds && now.matches.size() >= 2; ++round) {
    now.T_truth_map = align(now.matches, estimates, truth);
    std::vector<Match> next = match(transformed(now.T_truth_map, estimates), truth, gate_m);
    if (next == now.matches) break;
    now.matches = std::move(next);
  }
  return now;
}

Matching bestMatching(const Positions& estimates, const Positions& truth,
                      const LandmarkMatching& matching) {
  Matching best = matchFrom(matching.T_truth_map, estimates, truth, matching.gate_m);
  for (const Pose2& guess : matching.other_guesses) {
    Matching other = matchFrom(guess, estimates, truth, matching.gate_m);
    if (other.matches.size() > best.matches.size()) best = std::move(other);
  }
  return best;
}

/// Estimates without partner that stand within the gate of a true landmark.
std::size_t countDuplicates(const Matching& matching, const Positions& estimates,
                            const Positions& truth, double gate_m) {
  std::vector<bool> is_matched(estimates.size());
  for (const auto& [i, j] : matching.matches) is_matched[i] = true;
  std::size_t duplicates = 0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (is_matched[i]) continue;
    const Eigen::Vector2d p = matching.T_truth_map * estimates[i];
    duplicates += std::any_of(truth.begin(), truth.end(),
                              [&](const Eigen::Vector2d& t) { return (p - t).norm() <= gate_m; });
  }
  return duplicates;
}

}  // namespace

std::optional<LandmarkErrors> computeLandmarkErrors(const std::vector<LandmarkEstimate>& estimates,
                                                    const std::vector<Eigen::Vector2d>& truth,
                                                    const std::vector<StampedPose>& poses,
                                                    const LandmarkMatching& matching) {
  Positions positions;
  for (const LandmarkEstimate& estimate : estimates) positions.push_back(estimate.position);
  const Matching best = bestMatching(positions, truth, matching);
  const auto& [matches, T] = best;
  if (matches.empty()) return std::nullopt;

  LandmarkErrors errors;
  errors.T_truth_map = T;
  errors.distance_m = errorStatistics(distances(matches, matching.T_truth_map, positions, truth));
  errors.aligned_distance_m = errorStatistics(distances(matches, T, positions, truth));
  ConsistencySum nees;
  std::vector<bool> found(truth.size());
  for (const auto& [i, j] : matches) {
    found[j] = true;
    const Eigen::Matrix2d R = matching.T_truth_map.rotation();
    const Eigen::Vector2d e = R.transpose() * (matching.T_truth_map * positions[i] - truth[j]);
    const Eigen::LLT<Eigen::Matrix2d> cholesky(estimates[i].covariance);
    if (cholesky.info() == Eigen::Success) nees.add(e.dot(cholesky.solve(e)), 2);
  }
  errors.nees = nees.result();
  errors.false_landmarks = estimates.size() - matches.size();
  errors.duplicates = countDuplicates(best, positions, truth, matching.gate_m);
  for (std::size_t j = 0; j < truth.size(); ++j) {
    if (found[j]) continue;
    ++(isWithin(truth[j], poses, T, matching.missed_range_m) ? errors.missed : errors.out_of_range);
  }
  return errors;
}

}  // namespace hymm::core
