#include "cekf/tentative_landmarks.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {

TentativeLandmarks::TentativeLandmarks(const TentativeConfig& config) : config_(config) {}

bool TentativeLandmarks::observe(const Eigen::Vector2d& position, const Eigen::Matrix2d& covariance,
                                 LandmarkType type, long scan, double time_s, bool at_once) {
  const double radius_m = config_.gate_m + 3.0 * std::sqrt(covariance.diagonal().maxCoeff());
  Candidate* candidate = nearest(position, radius_m, type, scan);
  if (candidate == nullptr) {
    candidates_.push_back({type, {}});
    candidate = &candidates_.back();
  }
  std::vector<Sighting>& sightings = candidate->sightings;
  sightings.push_back({position, scan, time_s});
  forgetInfrequent(*candidate, scan);
  const bool often = sightings.size() >= static_cast<std::size_t>(config_.sightings);
  const bool long_enough = at_once || time_s - sightings.front().time_s >= config_.span_s;
  if (!often || !long_enough) return false;
  candidates_.erase(candidates_.begin() + (candidate - candidates_.data()));
  return true;
}

void TentativeLandmarks::expire(long scan) {
  const auto stale = [&](Candidate& candidate) {
    forgetInfrequent(candidate, scan);
    return candidate.sightings.empty();
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), stale),
                    candidates_.end());
}

void TentativeLandmarks::forgetInfrequent(Candidate& candidate, long scan) const {
  std::vector<Sighting>& sightings = candidate.sightings;
  // What comes into view may be missed at first, so the first few scans do not decide.
  const auto is_frequent = [&](std::size_t first) {
    const auto scans = static_cast<double>(scan - sightings[first].scan + 1);
    const auto seen = static_cast<double>(sightings.size() - first);
    return std::max(seen, double(config_.sightings)) >= config_.share * scans;
  };
  std::size_t first = 0;
  while (first < sightings.size() && !is_frequent(first)) ++first;
  sightings.erase(sightings.begin(), sightings.begin() + static_cast<std::ptrdiff_t>(first));
}

TentativeLandmarks::Candidate* TentativeLandmarks::nearest(const Eigen::Vector2d& position,
                                                           double radius_m, LandmarkType type,
                                                           long scan) {
  Candidate* best = nullptr;
  double best_distance = radius_m;
  for (Candidate& candidate : candidates_) {
    const double distance = (candidate.sightings.front().position - position).norm();
    const bool seen_in_this_scan = candidate.sightings.back().scan == scan;
    if (candidate.type != type || seen_in_this_scan || distance >= best_distance) continue;
    best = &candidate;
    best_distance = distance;
  }
  return best;
}

}  // namespace hymm::core
