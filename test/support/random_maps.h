#pragma once

#include <vector>

#include <Eigen/QR>
#include <Eigen/SVD>

#include "common/random.h"
#include "relocaliser/local_map.h"

namespace hymm::test {

inline Eigen::MatrixXd normalMatrix(core::RandomGenerator& generator, Eigen::Index rows,
                                    Eigen::Index columns) {
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix(i) = core::sampleNormal(generator, 1.0);
  return matrix;
}

/// Landmarks as a vehicle that never closes a loop maps them: each has the error of the pose that
/// it was seen from, which wanders, and one of its own. The vehicle stands at the end.
inline core::VehicleAmongLandmarks drivenMap(core::RandomGenerator& generator, int landmarks,
                                             double step_deviation_m, double own_deviation_m) {
  constexpr double kStep_m = 5.0;
  constexpr double kTurnPerMetre = 0.1;  // rad of heading error for a metre of position error
  const Eigen::Index n = landmarks;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n + 3, 3 * n);
  Eigen::VectorXd mean(2 * n + 3);
  const auto addSteps = [&](Eigen::Index row, Eigen::Index steps) {
    for (Eigen::Index k = 0; k < steps; ++k) {
      const Eigen::Vector2d arm =
          mean.segment<2>(row) - Eigen::Vector2d(kStep_m * static_cast<double>(k), 0.0);
      A.block<2, 2>(row, 3 * k) = step_deviation_m * Eigen::Matrix2d::Identity();
      A.block<2, 1>(row, 3 * k + 2) =
          step_deviation_m * kTurnPerMetre * Eigen::Vector2d(-arm.y(), arm.x());
    }
  };
  mean.head<3>() << kStep_m * static_cast<double>(n), 0.0,
      core::sampleUniform(generator, -3.0, 3.0);
  addSteps(0, n);
  for (Eigen::Index k = 0; k < n; ++k) A(2, 3 * k + 2) = step_deviation_m * kTurnPerMetre;
  core::VehicleAmongLandmarks estimate;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index row = 3 + 2 * i;
    mean.segment<2>(row) << kStep_m * static_cast<double>(i) +
                                core::sampleUniform(generator, -15.0, 15.0),
        core::sampleUniform(generator, -20.0, 20.0);
    addSteps(row, i + 1);
    estimate.landmarks.ids.push_back(static_cast<int>(i));
  }
  Eigen::MatrixXd P = A * A.transpose();
  P.diagonal().tail(2 * n).array() += own_deviation_m * own_deviation_m;
  estimate.landmarks.mean = mean.tail(2 * n);
  estimate.landmarks.covariance = P.bottomRightCorner(2 * n, 2 * n);
  estimate.vehicle = {core::Pose2::fromVector(mean.head<3>()), P.topLeftCorner<3, 3>()};
  estimate.cross_covariance = P.topRightCorner(3, 2 * n);
  return estimate;
}

/// A number that no block-diagonal bound of `P`, in blocks of two states, can have a lesser trace
/// than: the dual of that problem, max tr(P Y) over Y >= 0 with unit blocks on its diagonal, here
/// with Y = V' V of low rank by coordinate ascent. Any V gives a valid number; at the optimum it is
/// the least trace itself.
inline double leastTraceOfBlockBound(const Eigen::MatrixXd& P, core::RandomGenerator& generator) {
  constexpr Eigen::Index kRank = 18;  // enough for 40 blocks to have no other local optimum
  constexpr int kSweeps = 60;
  const Eigen::Index n = P.rows() / 2;
  Eigen::MatrixXd V(kRank, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(normalMatrix(generator, kRank, 2));
    V.middleCols<2>(2 * i) = qr.householderQ() * Eigen::MatrixXd::Identity(kRank, 2);
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::MatrixXd pull =
          V * P.middleCols<2>(2 * i) - V.middleCols<2>(2 * i) * P.block<2, 2>(2 * i, 2 * i);
      if (pull.isZero(0.0)) continue;
      const Eigen::JacobiSVD<Eigen::MatrixXd> svd(pull, Eigen::ComputeThinU | Eigen::ComputeThinV);
      V.middleCols<2>(2 * i) = svd.matrixU() * svd.matrixV().transpose();
    }
  }
  return (V * P).cwiseProduct(V).sum();
}

}  // namespace hymm::test
