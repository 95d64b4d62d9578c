#include "cekf/duplicate_search.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "cekf/pairing_evidence.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Bounds the work where the vehicle is very uncertain among many landmarks.
constexpr std::size_t kMaxCandidates = 5;

Matrix2d differenceCovariance(const DuplicateLandmarks& a, const DuplicateLandmarks& b,
                              const CompressedEkf& filter) {
  return filter.covariance(a.gone, b.gone) - filter.covariance(a.gone, b.kept) -
         filter.covariance(a.kept, b.gone) + filter.covariance(a.kept, b.kept);
}

}  // namespace

DuplicateSearch::DuplicateSearch(const LandmarkConfig& landmarks,
                                 const AssociationConfig& association)
    : landmarks_(landmarks),
      association_(association),
      gate_(chiSquareQuantile(association.individual_probability, 2)),
      least_log_odds_(-std::log(landmarks.constellation_coincidence)),
      joint_({chiSquareQuantile(association.unpaired_probability, 2), association.joint_probability,
              association.max_nodes}) {}

std::vector<DuplicateLandmarks> DuplicateSearch::find(double time_s, const Vector2d& vehicle,
                                                      const AreDistinct& are_distinct,
                                                      const LandmarkRegistry& registry,
                                                      CompressedEkf& filter) const {
  std::vector<Candidate> candidates;
  int recent = 0;
  for (const int slot : registry.slotsNear(vehicle, landmarks_.constellation_radius_m)) {
    const RegisteredLandmark& landmark = registry.bySlot(slot);
    if (landmark.identity >= 0) continue;
    if (time_s - landmark.last_seen_s > landmarks_.constellation_span_s) continue;
    const auto own = candidatesOf(recent, landmark, are_distinct, registry, filter);
    if (own.empty()) continue;
    candidates.insert(candidates.end(), own.begin(), own.end());
    ++recent;
  }
  return candidates.empty() ? std::vector<DuplicateLandmarks>{}
                            : choose(candidates, recent, filter);
}

std::vector<DuplicateSearch::Candidate> DuplicateSearch::candidatesOf(
    int recent_number, const RegisteredLandmark& recent, const AreDistinct& are_distinct,
    const LandmarkRegistry& registry, CompressedEkf& filter) const {
  const double gate = std::sqrt(gate_);
  std::vector<Candidate> candidates;
  for (const int slot : registry.slotsNear(
           recent.position, gate * (recent.deviation_m + registry.largestDeviation()))) {
    const RegisteredLandmark& older = registry.bySlot(slot);
    const double reach_m = gate * (recent.deviation_m + older.deviation_m);
    // What was still seen when the recent one came into the map is another object.
    if (slot == recent.slot || older.last_seen_s >= recent.first_seen_s) continue;
    if ((older.position - recent.position).norm() > reach_m) continue;
    if (!mayBeOneKind(older.type, recent.type) || are_distinct(slot, recent.slot)) continue;
    filter.activate(recent.slot);
    filter.activate(slot);
    Candidate candidate;
    candidate.pair = {slot, recent.slot};
    const Vector2d difference = filter.landmark(recent.slot) - filter.landmark(slot);
    const Matrix2d S = differenceCovariance(candidate.pair, candidate.pair, filter);
    candidate.distance2 = difference.dot(S.inverse() * difference);
    if (!(candidate.distance2 <= gate_)) continue;
    candidate.pairing = {recent_number, slot, difference, 0.0,
                         association_.unmapped_density_per_m2};
    candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.distance2 < b.distance2; });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  return candidates;
}

std::vector<DuplicateLandmarks> DuplicateSearch::choose(const std::vector<Candidate>& candidates,
                                                        int recent,
                                                        const CompressedEkf& filter) const {
  const auto n = static_cast<Eigen::Index>(candidates.size());
  std::vector<Pairing> pairings;
  Eigen::MatrixXd S(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Candidate& a = candidates[static_cast<std::size_t>(i)];
    pairings.push_back(a.pairing);
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Candidate& b = candidates[static_cast<std::size_t>(j)];
      S.block<2, 2>(2 * i, 2 * j) = differenceCovariance(a.pair, b.pair, filter);
      S.block<2, 2>(2 * j, 2 * i) = S.block<2, 2>(2 * i, 2 * j).transpose();
    }
  }
  std::vector<int> chosen;
  for (const int pairing : joint_.find(pairings, S, recent).pairings) {
    if (pairing >= 0) chosen.push_back(pairing);
  }
  std::vector<DuplicateLandmarks> duplicates;
  for (const int pairing : provenPairings(chosen, pairings, S, least_log_odds_)) {
    duplicates.push_back(candidates[static_cast<std::size_t>(pairing)].pair);
  }
  // One that goes into another cannot take up a third: that one is left for the next search.
  const std::vector<DuplicateLandmarks> all = duplicates;
  const auto goes = [&all](const DuplicateLandmarks& pair) {
    return std::any_of(all.begin(), all.end(),
                       [&pair](const auto& other) { return other.gone == pair.kept; });
  };
  duplicates.erase(std::remove_if(duplicates.begin(), duplicates.end(), goes), duplicates.end());
  return duplicates;
}

}  // namespace hymm::core
