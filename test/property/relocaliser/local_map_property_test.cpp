// The de-correlated map: its bound, its frame, and what it keeps of the joint estimate.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "relocaliser/block_bound.h"
#include "relocaliser/local_map.h"
#include "support/any.h"
#include "support/random_maps.h"

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::anyInteger;
using test::anyNumber;

/// Rounding of sums over hundreds of entries.
constexpr double kRounding = 1e-9;

std::vector<int> allOf(Index landmarks) {
  std::vector<int> all(static_cast<std::size_t>(landmarks));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

RandomGenerator anyGenerator() { return RandomGenerator(anyInteger(0U, 1000000U)); }

/// Any covariance: of any rank up to full, with deviations over several magnitudes.
MatrixXd anyCovariance(RandomGenerator& generator, Index states) {
  const auto rank = static_cast<Index>(anyInteger<int>(1, static_cast<int>(states) + 1));
  const double spread = anyNumber(0.0, 2.0);
  MatrixXd A = test::normalMatrix(generator, states, rank);
  for (Index i = 0; i < states; ++i) A.row(i) *= std::exp(spread * sampleNormal(generator, 1.0));
  return A * A.transpose();
}

VehicleAmongLandmarks anyDrivenMap(RandomGenerator& generator, int most) {
  return test::drivenMap(generator, anyInteger(3, most + 1), anyNumber(0.01, 0.3),
                         anyNumber(0.03, 0.3));
}

double leastEigenvalue(const MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

bool isConservative(const MatrixXd& bound, const MatrixXd& covariance) {
  return leastEigenvalue(bound - covariance) >= -kRounding * covariance.trace();
}

bool isBlockDiagonal(const MatrixXd& matrix, const std::vector<CovarianceBlock>& blocks) {
  MatrixXd rest = matrix;
  Index row = 0;
  for (const CovarianceBlock& block : blocks) {
    rest.block(row, row, block.size, block.size).setZero();
    row += block.size;
  }
  return rest.isZero(0.0);
}

/// Pose and landmarks as one Gaussian.
struct Joint {
  VectorXd mean;
  MatrixXd covariance;
};

Joint jointOf(const VehicleAmongLandmarks& estimate) {
  const Index states = estimate.landmarks.mean.size();
  Joint joint{VectorXd(3 + states), MatrixXd(3 + states, 3 + states)};
  joint.mean << estimate.vehicle.mean.vector(), estimate.landmarks.mean;
  joint.covariance << estimate.vehicle.covariance, estimate.cross_covariance,
      estimate.cross_covariance.transpose(), estimate.landmarks.covariance;
  return joint;
}

RC_GTEST_PROP(BlockBound, IsConservativeForAnyBlocksAndWeights, ()) {
  RandomGenerator generator = anyGenerator();
  std::vector<CovarianceBlock> blocks(static_cast<std::size_t>(anyInteger(1, 12)));
  Index states = 0;
  for (CovarianceBlock& block : blocks) {
    block.size = anyInteger(1, 4);
    block.weight = std::exp(anyNumber(-2.0, 2.0));
    states += block.size;
  }
  const MatrixXd P = anyCovariance(generator, states);
  const MatrixXd bound = computeBlockBound(P, blocks);
  RC_ASSERT(isBlockDiagonal(bound, blocks));
  RC_ASSERT(isConservative(bound, P));
}

RC_GTEST_PROP(BlockBound, OfAnyCovarianceIsAtMostTwiceTheBest, ()) {
  RandomGenerator generator = anyGenerator();
  const Index n = anyInteger(2, 41);
  const MatrixXd P = anyCovariance(generator, 2 * n);
  const double trace =
      computeBlockBound(P, std::vector<CovarianceBlock>(static_cast<std::size_t>(n))).trace();
  RC_ASSERT(trace <= 2.0 * test::leastTraceOfBlockBound(P, generator));
}

RC_GTEST_PROP(BlockBound, OfADrivenMapIsWithinATenthOfTheBest, ()) {
  RandomGenerator generator = anyGenerator();
  const Joint joint = jointOf(anyDrivenMap(generator, 40));
  const Index states = joint.mean.size() - 3;
  const FrameChoice frame =
      computeBestFrame(joint.mean.tail(states), joint.covariance.bottomRightCorner(states, states),
                       allOf(states / 2));
  const MatrixXd P = expressInFrame(joint.mean, joint.covariance, frame.origin, frame.axis)
                         .covariance.bottomRightCorner(states, states);
  const std::vector<CovarianceBlock> blocks(static_cast<std::size_t>(states / 2));
  RC_ASSERT(computeBlockBound(P, blocks).trace() <=
            1.1 * test::leastTraceOfBlockBound(P, generator));
}

RC_GTEST_PROP(LocalFrame, GivesTheCovarianceOfWhatItComputes, ()) {
  RandomGenerator generator = anyGenerator();
  const Joint joint = jointOf(anyDrivenMap(generator, 8));
  const int n = static_cast<int>(joint.mean.size() - 3) / 2;
  const int origin = anyInteger(0, n);
  const int axis = (origin + anyInteger(1, n)) % n;
  // Of a small disturbance the frame makes what its covariance says, whichever way it points.
  const VectorXd disturbance = 1e-6 * test::normalMatrix(generator, joint.mean.size(), 1);
  const FramedEstimate framed =
      expressInFrame(joint.mean, disturbance * disturbance.transpose(), origin, axis);
  const FramedEstimate moved =
      expressInFrame(joint.mean + disturbance, joint.covariance, origin, axis);
  VectorXd change = moved.mean - framed.mean;
  change[2] = wrapAngle(change[2]);
  RC_ASSERT((change * change.transpose() - framed.covariance).cwiseAbs().maxCoeff() <
            1e-3 * framed.covariance.trace());
  RC_ASSERT(framed.mean.segment<2>(3 + 2 * origin).norm() < kRounding);
  RC_ASSERT(std::abs(framed.mean[3 + 2 * axis + 1]) < kRounding);
}

RC_GTEST_PROP(LocalFrame, NoOtherPairOfLandmarksBoundsTighter, ()) {
  RandomGenerator generator = anyGenerator();
  const Joint joint = jointOf(anyDrivenMap(generator, 7));
  const Index states = joint.mean.size() - 3;
  const int n = static_cast<int>(states) / 2;
  const FrameChoice best =
      computeBestFrame(joint.mean.tail(states), joint.covariance.bottomRightCorner(states, states),
                       allOf(states / 2));
  double least = std::numeric_limits<double>::infinity();
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      if (a == b) continue;
      const MatrixXd P = expressInFrame(joint.mean, joint.covariance, a, b)
                             .covariance.bottomRightCorner(states, states);
      double trace = P.trace();
      for (int i = 0; i < n; ++i) {
        for (int j = i + 1; j < n; ++j) trace += 2.0 * nuclearNorm(P.block<2, 2>(2 * i, 2 * j));
      }
      if (a == best.origin && b == best.axis) {
        RC_ASSERT(std::abs(trace - best.bounded_trace_m2) < kRounding * trace);
      }
      least = std::min(least, trace);
    }
  }
  RC_ASSERT(best.bounded_trace_m2 <= least * (1.0 + kRounding));
}

RC_GTEST_PROP(LocalMap, IsConservativeForVehicleAndLandmarksTogether, ()) {
  RandomGenerator generator = anyGenerator();
  const VehicleAmongLandmarks estimate = anyDrivenMap(generator, 20);
  LocalMapConfig config;
  config.max_landmark_deviation_m = 1000.0;  // keeps all, so that all can be compared
  std::string problem;
  const auto map = tryMakeLocalMap(estimate, 1000.0, config, problem);
  RC_ASSERT(map.has_value());
  RC_ASSERT(map->landmarks.size() == estimate.landmarks.ids.size());
  const Joint joint = jointOf(estimate);
  const FramedEstimate framed =
      expressInFrame(joint.mean, joint.covariance, map->origin_id, map->axis_id);
  MatrixXd bound = MatrixXd::Zero(joint.mean.size(), joint.mean.size());
  bound.topLeftCorner<3, 3>() = map->vehicle.covariance;
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    const Index row = 3 + 2 * static_cast<Index>(i);
    bound.block<2, 2>(row, row) = map->landmarks[i].covariance;
    RC_ASSERT((map->landmarks[i].position - framed.mean.segment<2>(row)).norm() < kRounding);
  }
  RC_ASSERT(isConservative(bound, framed.covariance));
}

}  // namespace
}  // namespace hymm::core
