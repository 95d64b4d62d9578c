#include "cekf/duplicate_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "cekf/pairing_evidence.h"
#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

// These bound the work among many landmarks. Landmarks seen lately that are compared: the nearest.
constexpr std::size_t kMaxRecent = 40;
// Older ones that one may be, and those of them that are looked at, by what each is known to alone.
constexpr std::size_t kMaxCandidates = 5;
constexpr std::size_t kMaxLookedAt = 4 * kMaxCandidates;

constexpr double kAnyTime_s = std::numeric_limits<double>::infinity();

/// Leaves those slots that come first by `cost`, in the order that they had.
template <class Cost>
void keepCheapest(std::size_t most, std::vector<int>& slots, Cost&& cost) {
  if (slots.size() <= most) return;
  std::vector<double> costs;
  for (const int slot : slots) costs.push_back(cost(slot));
  std::vector<double> sorted = costs;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(most),
                   sorted.end());
  const double limit = sorted[most];
  std::size_t kept = 0;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (costs[i] < limit) slots[kept++] = slots[i];
  }
  slots.resize(kept);
}

Matrix2d differenceCovariance(const DuplicateLandmarks& a, const DuplicateLandmarks& b,
                              const CompressedEkf& filter) {
  return filter.covariance(a.gone, b.gone) - filter.covariance(a.gone, b.kept) -
         filter.covariance(a.kept, b.gone) + filter.covariance(a.kept, b.kept);
}

/// Of the differences of pairs, jointly.
MatrixXd differenceCovariance(const std::vector<DuplicateLandmarks>& pairs,
                              const CompressedEkf& filter) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  MatrixXd S(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      S.block<2, 2>(2 * i, 2 * j) = differenceCovariance(
          pairs[static_cast<std::size_t>(i)], pairs[static_cast<std::size_t>(j)], filter);
      if (j < i) S.block<2, 2>(2 * j, 2 * i) = S.block<2, 2>(2 * i, 2 * j).transpose();
    }
  }
  return S;
}

/// How the landmarks seen lately move when all of them do as one body with the vehicle.
MatrixXd turnsAbout(const Vector2d& vehicle, const std::vector<DuplicateLandmarks>& pairs,
                    const CompressedEkf& filter) {
  MatrixXd A(2 * static_cast<Eigen::Index>(pairs.size()), 3);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    A.middleRows<2>(2 * static_cast<Eigen::Index>(k)) =
        rigidMotion(filter.landmark(pairs[k].gone) - vehicle);
  }
  return A;
}

}  // namespace

DuplicateSearch::DuplicateSearch(const LandmarkConfig& landmarks,
                                 const AssociationConfig& association, const SlipConfig& slip)
    : landmarks_(landmarks),
      association_(association),
      slip_(slip),
      gate_(chiSquareQuantile(association.individual_probability, 2)),
      least_log_odds_(-std::log(landmarks.constellation_coincidence)),
      joint_({chiSquareQuantile(association.unpaired_probability, 2), association.joint_probability,
              association.max_nodes}) {}

std::vector<DuplicateLandmarks> DuplicateSearch::pairsOf(const Candidates& candidates) {
  std::vector<DuplicateLandmarks> pairs;
  for (const Candidate& candidate : candidates.all) pairs.push_back(candidate.pair);
  return pairs;
}

DuplicatesFound DuplicateSearch::find(double time_s, const Vector2d& vehicle,
                                      const AreDistinct& are_distinct,
                                      const LandmarkRegistry& registry,
                                      CompressedEkf& filter) const {
  std::vector<int> recent;
  double known_since_s = kAnyTime_s;
  for (const int slot : registry.slotsNear(vehicle, landmarks_.constellation_radius_m)) {
    const RegisteredLandmark& landmark = registry.bySlot(slot);
    if (landmark.identity >= 0) continue;
    if (time_s - landmark.last_seen_s > landmarks_.constellation_span_s) continue;
    recent.push_back(slot);
  }
  keepCheapest(kMaxRecent, recent,
               [&](int slot) { return (registry.bySlot(slot).position - vehicle).squaredNorm(); });
  for (const int slot : recent) {
    known_since_s = std::min(known_since_s, registry.bySlot(slot).first_seen_s);
  }
  const Candidates fitting = candidates(recent, {1.0, kAnyTime_s}, are_distinct, registry, filter);
  const MatrixXd S = differenceCovariance(pairsOf(fitting), filter);
  DuplicatesFound found{choose(fitting, S, least_log_odds_), std::nullopt};
  if (!found.pairs.empty() || !(slip_.probability > 0.0)) return found;
  // No slip lies between landmarks of which the one was still seen when the other came.
  const Candidates near =
      candidates(recent, {slip_.factor, known_since_s}, are_distinct, registry, filter);
  return findAfterSlip(near, vehicle, filter);
}

DuplicateSearch::Candidates DuplicateSearch::candidates(const std::vector<int>& recent,
                                                        const Reach& reach,
                                                        const AreDistinct& are_distinct,
                                                        const LandmarkRegistry& registry,
                                                        CompressedEkf& filter) const {
  Candidates result;
  for (const int slot : recent) {
    const auto own =
        candidatesOf(result.recent, registry.bySlot(slot), reach, are_distinct, registry, filter);
    if (own.empty()) continue;
    result.all.insert(result.all.end(), own.begin(), own.end());
    ++result.recent;
  }
  return result;
}

/// What the filter claims of how the landmarks seen lately lie to the older ones, as one body, is
/// that of the vehicle's way between. If that was worse, they lie otherwise, as one body.
DuplicatesFound DuplicateSearch::findAfterSlip(const Candidates& candidates,
                                               const Vector2d& vehicle,
                                               const CompressedEkf& filter) const {
  if (candidates.recent < 2) return {};
  std::vector<DuplicateLandmarks> bodies;  // each landmark seen lately, with the nearest older one
  for (const Candidate& candidate : candidates.all) {
    const bool is_first = bodies.empty() || bodies.back().gone != candidate.pair.gone;
    if (is_first) bodies.push_back(candidate.pair);
  }
  const MatrixXd A = turnsAbout(vehicle, bodies, filter);
  const Eigen::LLT<MatrixXd> S_bodies(differenceCovariance(bodies, filter));
  if (S_bodies.info() != Eigen::Success) return {};
  const Matrix3d claimed = (A.transpose() * S_bodies.solve(A)).inverse();
  if (!claimed.allFinite()) return {};
  const Matrix3d slip = (slip_.factor * slip_.factor - 1.0) * claimed;

  const std::vector<DuplicateLandmarks> pairs = pairsOf(candidates);
  const MatrixXd A_pairs = turnsAbout(vehicle, pairs, filter);
  const MatrixXd S = differenceCovariance(pairs, filter) + A_pairs * slip * A_pairs.transpose();
  return {choose(candidates, S, least_log_odds_ - std::log(slip_.probability)), slip};
}

/// Slots of older landmarks that a recent one may be, by what each is known to alone. `gate`: in
/// deviations.
std::vector<int> DuplicateSearch::olderNear(const RegisteredLandmark& recent, double gate,
                                            const Reach& reach, const AreDistinct& are_distinct,
                                            const LandmarkRegistry& registry) const {
  std::vector<int> slots = registry.slotsNear(
      recent.position, gate * (recent.deviation_m + registry.largestDeviation()));
  const auto isOther = [&](int slot) {
    const RegisteredLandmark& older = registry.bySlot(slot);
    double reach_m = gate * (recent.deviation_m + older.deviation_m);
    if (reach.widened > 1.0) reach_m = std::min(reach_m, landmarks_.constellation_radius_m);
    // What was still seen when the recent one came into the map is another object.
    return slot == recent.slot || older.last_seen_s >= recent.first_seen_s ||
           older.last_seen_s >= reach.before_s ||
           (older.position - recent.position).norm() > reach_m ||
           !mayBeOneKind(older.type, recent.type) || are_distinct(slot, recent.slot);
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), isOther), slots.end());
  keepCheapest(kMaxLookedAt, slots, [&](int slot) {
    const RegisteredLandmark& older = registry.bySlot(slot);
    return (older.position - recent.position).norm() / (recent.deviation_m + older.deviation_m);
  });
  return slots;
}

std::vector<DuplicateSearch::Candidate> DuplicateSearch::candidatesOf(
    int recent_number, const RegisteredLandmark& recent, const Reach& reach,
    const AreDistinct& are_distinct, const LandmarkRegistry& registry,
    CompressedEkf& filter) const {
  const double gate = reach.widened * std::sqrt(gate_);
  std::vector<Candidate> candidates;
  for (const int slot : olderNear(recent, gate, reach, are_distinct, registry)) {
    filter.activate(recent.slot);
    filter.activate(slot);
    Candidate candidate;
    candidate.pair = {slot, recent.slot};
    const Vector2d difference = filter.landmark(recent.slot) - filter.landmark(slot);
    const Matrix2d S = differenceCovariance(candidate.pair, candidate.pair, filter);
    candidate.distance2 = difference.dot(S.inverse() * difference);
    if (!(candidate.distance2 <= gate * gate)) continue;
    candidate.pairing = {recent_number, slot, difference, 0.0,
                         association_.unmapped_density_per_m2};
    candidates.push_back(candidate);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.distance2 < b.distance2; });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  return candidates;
}

/// `S`: covariance of the candidates' differences. What is chosen has `least_log_odds` together.
std::vector<DuplicateLandmarks> DuplicateSearch::choose(const Candidates& candidates,
                                                        const MatrixXd& S,
                                                        double least_log_odds) const {
  std::vector<Pairing> pairings;
  for (const Candidate& candidate : candidates.all) pairings.push_back(candidate.pairing);
  const JointHypothesis best = joint_.find(pairings, S, candidates.recent);
  const std::vector<int> chosen =
      undisputedPairings(joint_, best.pairings, pairings, S, least_log_odds_);
  const std::vector<int> proven = provenPairings(chosen, pairings, S, least_log_odds_);
  if (proven.empty() || logOdds(proven, pairings, S) < least_log_odds) return {};
  std::vector<DuplicateLandmarks> duplicates;
  for (const int pairing : proven) {
    duplicates.push_back(candidates.all[static_cast<std::size_t>(pairing)].pair);
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
