// Joint compatibility against the enumeration of all hypotheses.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "cekf/joint_compatibility.h"
#include "common/random.h"
#include "support/any.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::anyInteger;

constexpr double kUnpairedCost = 9.21;

struct Problem {
  std::vector<Pairing> pairings;
  MatrixXd S;
  int observations = 0;
};

/// Up to five observations of up to four candidates each, whose innovations share the errors of one
/// pose; small landmark numbers, so that observations compete for landmarks.
Problem anyProblem() {
  Problem problem;
  problem.observations = anyInteger(1, 6);
  RandomGenerator generator(anyInteger(0U, 1000000U));
  for (int i = 0; i < problem.observations; ++i) {
    std::vector<int> landmarks{0, 1, 2, 3, 4, 5};
    std::shuffle(landmarks.begin(), landmarks.end(), generator);
    const int candidates = anyInteger(0, 5);
    for (int k = 0; k < candidates; ++k) {
      Pairing pairing;
      pairing.observation = i;
      pairing.landmark = landmarks[static_cast<std::size_t>(k)];
      pairing.innovation << sampleNormal(generator, 1.5), sampleNormal(generator, 1.5);
      pairing.cue_cost = sampleUniform(generator, 0.0, 2.0);
      problem.pairings.push_back(pairing);
    }
  }
  const auto n = static_cast<Eigen::Index>(problem.pairings.size());
  MatrixXd common(2 * n, 3);
  for (Eigen::Index i = 0; i < common.size(); ++i) common(i) = sampleNormal(generator, 1.0);
  problem.S = common * common.transpose() + 0.2 * MatrixXd::Identity(2 * n, 2 * n);
  return problem;
}

/// What the hypothesis costs; nothing if it uses a landmark twice or fails the joint gate.
std::optional<double> costOf(const Problem& problem, const std::vector<int>& chosen,
                             const JointCompatibility& joint) {
  std::vector<std::size_t> used;
  std::set<int> landmarks;
  double cue = 0.0;
  for (const int k : chosen) {
    if (k < 0) continue;
    const Pairing& pairing = problem.pairings[static_cast<std::size_t>(k)];
    used.push_back(static_cast<std::size_t>(k));
    cue += pairing.cue_cost;
    if (!landmarks.insert(pairing.landmark).second) return std::nullopt;
  }
  const auto m = static_cast<Eigen::Index>(used.size());
  MatrixXd S(2 * m, 2 * m);
  VectorXd z(2 * m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const auto row = used[static_cast<std::size_t>(a)];
    z.segment<2>(2 * a) = problem.pairings[row].innovation;
    for (Eigen::Index b = 0; b < m; ++b) {
      S.block<2, 2>(2 * a, 2 * b) =
          problem.S.block<2, 2>(2 * static_cast<Eigen::Index>(row),
                                2 * static_cast<Eigen::Index>(used[static_cast<std::size_t>(b)]));
    }
  }
  const double distance2 = m > 0 ? z.dot(S.ldlt().solve(z)) : 0.0;
  if (distance2 > joint.gate(static_cast<int>(m))) return std::nullopt;
  return distance2 + cue + kUnpairedCost * static_cast<double>(problem.observations - m);
}

double leastCost(const Problem& problem, const JointCompatibility& joint, std::vector<int>& chosen,
                 std::size_t observation) {
  if (observation == chosen.size()) {
    return costOf(problem, chosen, joint).value_or(std::numeric_limits<double>::infinity());
  }
  chosen[observation] = -1;
  double least = leastCost(problem, joint, chosen, observation + 1);
  for (std::size_t k = 0; k < problem.pairings.size(); ++k) {
    if (problem.pairings[k].observation != static_cast<int>(observation)) continue;
    chosen[observation] = static_cast<int>(k);
    least = std::min(least, leastCost(problem, joint, chosen, observation + 1));
  }
  chosen[observation] = -1;
  return least;
}

JointHypothesis find(const Problem& problem, const JointCompatibility& joint) {
  return joint.find(problem.pairings, problem.S, problem.observations);
}

RC_GTEST_PROP(JointCompatibility, CostsNoMoreThanAnyOtherHypothesis, ()) {
  const Problem problem = anyProblem();
  const JointCompatibility joint({kUnpairedCost, 0.99, 1000000});
  const JointHypothesis found = find(problem, joint);
  RC_ASSERT(found.complete);
  const auto cost = costOf(problem, found.pairings, joint);
  RC_ASSERT(cost.has_value());
  std::vector<int> chosen(static_cast<std::size_t>(problem.observations), -1);
  RC_ASSERT(*cost < leastCost(problem, joint, chosen, 0) + 1e-9);
}

RC_GTEST_PROP(JointCompatibility, IsValidWhateverItsBound, ()) {
  const Problem problem = anyProblem();
  const int bound = anyInteger(1, 30);
  const JointCompatibility joint({kUnpairedCost, 0.99, bound});
  const JointHypothesis found = find(problem, joint);
  const auto cost = costOf(problem, found.pairings, joint);
  RC_ASSERT(cost.has_value());
  RC_ASSERT(*cost <= kUnpairedCost * problem.observations + 1e-9);
  const JointHypothesis best = find(problem, JointCompatibility({kUnpairedCost, 0.99, 1000000}));
  if (found.complete) RC_ASSERT(found.pairings == best.pairings);
}

RC_GTEST_PROP(JointCompatibility, TellsThePairsAndTheDistanceOfWhatItFound, ()) {
  const Problem problem = anyProblem();
  const JointCompatibility joint({kUnpairedCost, 0.99, 1000000});
  const JointHypothesis found = find(problem, joint);
  int paired = 0;
  double cue = 0.0;
  for (std::size_t i = 0; i < found.pairings.size(); ++i) {
    if (found.pairings[i] < 0) continue;
    const Pairing& pairing = problem.pairings[static_cast<std::size_t>(found.pairings[i])];
    RC_ASSERT(pairing.observation == static_cast<int>(i));
    ++paired;
    cue += pairing.cue_cost;
  }
  RC_ASSERT(found.paired == paired);
  const double cost = found.mahalanobis2 + cue + kUnpairedCost * (problem.observations - paired);
  RC_ASSERT(std::abs(cost - *costOf(problem, found.pairings, joint)) < 1e-9);
}

}  // namespace
}  // namespace hymm::core
