#include "cekf/tentative_landmarks.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

TentativeLandmarks::TentativeLandmarks(const TentativeConfig& config) : config_(config) {}

bool TentativeLandmarks::observe(const Eigen::Vector2d& position, const Eigen::Matrix2d& covariance,
                                 LandmarkType type, long scan) {
  const double radius_m = config_.gate_m + 3.0 * std::sqrt(covariance.diagonal().maxCoeff());
  Candidate* candidate = nearest(position, radius_m, type, scan);
  if (candidate == nullptr) {
    candidates_.push_back({position, type, {}});
    candidate = &candidates_.back();
  }
  candidate->position = position;
  candidate->scans.push_back(scan);
  const auto recent = std::count_if(candidate->scans.begin(), candidate->scans.end(),
                                    [&](long s) { return s > scan - config_.within_scans; });
  if (recent < config_.sightings) return false;
  candidates_.erase(candidates_.begin() + (candidate - candidates_.data()));
  return true;
}

void TentativeLandmarks::expire(long scan) {
  const auto stale = [&](const Candidate& candidate) {
    return candidate.scans.back() <= scan - config_.within_scans;
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), stale),
                    candidates_.end());
}

TentativeLandmarks::Candidate* TentativeLandmarks::nearest(const Eigen::Vector2d& position,
                                                           double radius_m, LandmarkType type,
                                                           long scan) {
  Candidate* best = nullptr;
  double best_distance = radius_m;
  for (Candidate& candidate : candidates_) {
    const double distance = (candidate.position - position).norm();
    const bool seen_in_this_scan = candidate.scans.back() == scan;
    if (candidate.type != type || seen_in_this_scan || distance >= best_distance) continue;
    best = &candidate;
    best_distance = distance;
  }
  return best;
}

}  // namespace hymm::core
