#include "cekf/joint_compatibility.h"

#include <cmath>
#include <functional>
#include <limits>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

struct Problem {
  std::vector<Pairing> pairings;
  MatrixXd S;
  int observations = 0;
};

/// Random innovations whose covariance has a large part in common, as that of one vehicle pose.
Problem randomProblem(RandomGenerator& generator, int observations, int candidates) {
  Problem problem;
  problem.observations = observations;
  const int n = observations * candidates;
  MatrixXd common(2 * n, 3);
  for (int i = 0; i < common.size(); ++i) common(i) = sampleNormal(generator, 1.0);
  problem.S = common * common.transpose() + 0.2 * MatrixXd::Identity(2 * n, 2 * n);
  for (int i = 0; i < n; ++i) {
    Pairing pairing;
    pairing.observation = i / candidates;
    pairing.landmark = std::uniform_int_distribution<int>(0, observations)(generator);
    pairing.innovation << sampleNormal(generator, 1.5), sampleNormal(generator, 1.5);
    pairing.cue_cost = sampleUniform(generator, 0.0, 2.0);
    problem.pairings.push_back(pairing);
  }
  return problem;
}

/// As met on a drive: innovations have the covariance that they are said to have, but for some that
/// are of another landmark, and some observations have a second candidate.
Problem drawnFrom(RandomGenerator& generator, int observations) {
  Problem problem = randomProblem(generator, observations + 2, 1);
  problem.observations = observations;
  const Eigen::LLT<MatrixXd> factor(problem.S);
  Eigen::VectorXd white(problem.S.rows());
  for (double& value : white) value = sampleNormal(generator, 1.0);
  const Eigen::VectorXd innovations = factor.matrixL() * white;
  for (std::size_t k = 0; k < problem.pairings.size(); ++k) {
    Pairing& pairing = problem.pairings[k];
    pairing.landmark = static_cast<int>(k);
    pairing.innovation = innovations.segment<2>(2 * static_cast<Eigen::Index>(k));
    const double other_m = sampleUniform(generator, 0.0, 1.0) < 0.3 ? 3.0 : 0.0;
    pairing.innovation.x() += sampleNormal(generator, other_m);
    if (static_cast<int>(k) >= observations)
      pairing.observation = static_cast<int>(k) - observations;
  }
  return problem;
}

double costOf(const Problem& problem, const std::vector<int>& chosen,
              const JointCompatibility& joint) {
  std::vector<int> used;
  double cue = 0.0;
  for (const int k : chosen) {
    if (k < 0) continue;
    for (const int other : used) {
      if (problem.pairings[static_cast<std::size_t>(other)].landmark ==
          problem.pairings[static_cast<std::size_t>(k)].landmark) {
        return std::numeric_limits<double>::infinity();
      }
    }
    used.push_back(k);
    cue += problem.pairings[static_cast<std::size_t>(k)].cue_cost;
  }
  const auto m = static_cast<Eigen::Index>(used.size());
  MatrixXd S(2 * m, 2 * m);
  Eigen::VectorXd z(2 * m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const int ka = used[static_cast<std::size_t>(a)];
    z.segment<2>(2 * a) = problem.pairings[static_cast<std::size_t>(ka)].innovation;
    for (Eigen::Index b = 0; b < m; ++b) {
      S.block<2, 2>(2 * a, 2 * b) =
          problem.S.block<2, 2>(2 * ka, 2 * used[static_cast<std::size_t>(b)]);
    }
  }
  const double distance2 = m > 0 ? z.dot(S.inverse() * z) : 0.0;
  if (distance2 > joint.gate(static_cast<int>(m))) return std::numeric_limits<double>::infinity();
  return distance2 + cue +
         joint.limits().unpaired_cost * (problem.observations - static_cast<double>(m));
}

double cheapestByEnumeration(const Problem& problem, const JointCompatibility& joint) {
  std::vector<int> chosen(static_cast<std::size_t>(problem.observations), -1);
  double best = std::numeric_limits<double>::infinity();
  const std::function<void(std::size_t)> descend = [&](std::size_t observation) {
    if (observation == chosen.size()) {
      best = std::min(best, costOf(problem, chosen, joint));
      return;
    }
    chosen[observation] = -1;
    descend(observation + 1);
    for (std::size_t k = 0; k < problem.pairings.size(); ++k) {
      if (problem.pairings[k].observation != static_cast<int>(observation)) continue;
      chosen[observation] = static_cast<int>(k);
      descend(observation + 1);
    }
    chosen[observation] = -1;
  };
  descend(0);
  return best;
}

TEST(JointCompatibility, FindsTheCheapestOfAllHypotheses) {
  RandomGenerator generator(5);
  const JointCompatibility joint({9.21, 0.99, 1000000});
  for (int trial = 0; trial < 60; ++trial) {
    const Problem problem = randomProblem(generator, 4, 3);
    const JointHypothesis found = joint.find(problem.pairings, problem.S, problem.observations);
    EXPECT_TRUE(found.complete);
    EXPECT_NEAR(costOf(problem, found.pairings, joint), cheapestByEnumeration(problem, joint),
                1e-9);
  }
}

TEST(JointCompatibility, FindsTheCheapestWhereMostObservationsHaveOneCandidate) {
  RandomGenerator generator(6);
  const JointCompatibility joint({9.21, 0.99999, 1000000});
  int left_out = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Problem problem = drawnFrom(generator, 8);
    const JointHypothesis found = joint.find(problem.pairings, problem.S, problem.observations);
    EXPECT_TRUE(found.complete);
    EXPECT_NEAR(costOf(problem, found.pairings, joint), cheapestByEnumeration(problem, joint),
                1e-9);
    left_out += problem.observations - found.paired;
  }
  EXPECT_GT(left_out, 200);  // or nothing was to be found out
}

TEST(JointCompatibility, UsesALandmarkOnce) {
  Problem problem;
  problem.observations = 2;
  problem.pairings = {{0, 7, Vector2d(0.1, 0.0), 0.0}, {1, 7, Vector2d(0.0, 0.0), 0.0}};
  problem.S = MatrixXd::Identity(4, 4);
  const JointHypothesis found =
      JointCompatibility({9.21, 0.99, 1000}).find(problem.pairings, problem.S, 2);
  EXPECT_EQ(found.paired, 1);
  EXPECT_EQ(found.pairings[0], -1);
  EXPECT_EQ(found.pairings[1], 1);
}

TEST(JointCompatibility, LeavesOutWhatContradictsTheOthers) {
  // All innovations share the vehicle's error of deviation 1; two agree on +1, one says -1.
  Problem problem;
  problem.observations = 3;
  problem.pairings = {{0, 1, Vector2d(1.0, 1.0), 0.0},
                      {1, 2, Vector2d(1.0, 1.0), 0.0},
                      {2, 3, Vector2d(-1.0, -1.0), 0.0}};
  MatrixXd shared(6, 2);
  shared << MatrixXd::Identity(2, 2), MatrixXd::Identity(2, 2), MatrixXd::Identity(2, 2);
  problem.S = shared * shared.transpose() + 0.01 * MatrixXd::Identity(6, 6);
  const JointHypothesis found =
      JointCompatibility({9.21, 0.99, 1000}).find(problem.pairings, problem.S, 3);
  EXPECT_EQ(found.paired, 2);
  EXPECT_EQ(found.pairings[2], -1);
}

TEST(JointCompatibility, StopsAtItsBoundWithTheBestSoFar) {
  RandomGenerator generator(6);
  const Problem problem = randomProblem(generator, 8, 4);
  const JointHypothesis found =
      JointCompatibility({9.21, 0.99, 10}).find(problem.pairings, problem.S, 8);
  EXPECT_FALSE(found.complete);
  EXPECT_EQ(found.pairings.size(), 8U);
}

TEST(JointCompatibility, PairsNothingWithoutCandidates) {
  const JointHypothesis found = JointCompatibility({}).find({}, MatrixXd(0, 0), 3);
  EXPECT_EQ(found.paired, 0);
  EXPECT_EQ(found.pairings, std::vector<int>(3, -1));
}

}  // namespace
}  // namespace hymm::core
