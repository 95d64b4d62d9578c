#include <cmath>
#include <limits>

#include "relocaliser/block_bound.h"
#include "relocaliser/local_map.h"

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// A vector turned by a quarter, counter-clockwise.
Vector2d quarterTurned(const Vector2d& v) { return {-v.y(), v.x()}; }

/// Derivative of the direction of `v` by `v`.
Vector2d directionGradient(const Vector2d& v) { return quarterTurned(v) / v.squaredNorm(); }

/// Landmarks relative to one of them, in the axes of the map.
struct RelativeLandmarks {
  RelativeLandmarks(const VectorXd& mean, const MatrixXd& P, Index origin)
      : offset(mean), covariance(P) {
    const Index n = mean.size() / 2;
    const Matrix2d P_oo = P.block<2, 2>(2 * origin, 2 * origin);
    for (Index i = 0; i < n; ++i) {
      offset.segment<2>(2 * i) -= mean.segment<2>(2 * origin);
      for (Index j = 0; j < n; ++j) {
        covariance.block<2, 2>(2 * i, 2 * j) +=
            P_oo - P.block<2, 2>(2 * origin, 2 * j) - P.block<2, 2>(2 * i, 2 * origin);
      }
    }
  }

  /// Trace of the bound (37) once the axes follow landmark `axis`. Neither traces nor singular
  /// values change under rotation, so the blocks need not be turned.
  double boundedTrace(Index axis) const {
    const Index n = offset.size() / 2;
    const Vector2d g = directionGradient(offset.segment<2>(2 * axis));
    const MatrixXd with_direction = covariance.middleCols<2>(2 * axis) * g;
    const double direction_variance = g.dot(with_direction.block<2, 1>(2 * axis, 0));
    double trace = 0.0;
    for (Index i = 0; i < n; ++i) {
      const Vector2d t_i = quarterTurned(offset.segment<2>(2 * i));
      const Vector2d c_i = with_direction.block<2, 1>(2 * i, 0);
      for (Index j = i; j < n; ++j) {
        const Vector2d t_j = quarterTurned(offset.segment<2>(2 * j));
        const Vector2d c_j = with_direction.block<2, 1>(2 * j, 0);
        const Matrix2d block = covariance.block<2, 2>(2 * i, 2 * j) - t_i * c_j.transpose() -
                               c_i * t_j.transpose() + direction_variance * t_i * t_j.transpose();
        trace += i == j ? block.trace() : 2.0 * nuclearNorm(block);
      }
    }
    return trace;
  }

  VectorXd offset;      ///< m
  MatrixXd covariance;  ///< m^2
};

}  // namespace

FrameChoice computeBestFrame(const VectorXd& mean, const MatrixXd& covariance,
                             const std::vector<int>& candidates) {
  FrameChoice best{candidates.at(0), candidates.at(1), std::numeric_limits<double>::infinity()};
  for (const int origin : candidates) {
    const RelativeLandmarks relative(mean, covariance, origin);
    for (const int axis : candidates) {
      if (relative.offset.segment<2>(2 * axis).squaredNorm() == 0.0) continue;
      const double trace = relative.boundedTrace(axis);
      if (trace < best.bounded_trace_m2) best = {origin, axis, trace};
    }
  }
  return best;
}

FramedEstimate expressInFrame(const VectorXd& mean, const MatrixXd& covariance, int origin,
                              int axis) {
  const Index a = 3 + 2 * origin, b = 3 + 2 * axis;
  const Vector2d p_a = mean.segment<2>(a), along = mean.segment<2>(b) - p_a;
  const double yaw = std::atan2(along.y(), along.x());
  FramedEstimate framed{{p_a.x(), p_a.y(), yaw}, mean, {}};
  const Matrix2d R = framed.T_map_local.rotation().transpose();
  const Vector2d g = directionGradient(along);

  MatrixXd J = MatrixXd::Zero(mean.size(), mean.size());
  const auto place = [&](Index row) {
    const Vector2d local = R * (mean.segment<2>(row) - p_a);
    framed.mean.segment<2>(row) = local;
    const Matrix2d by_direction = -quarterTurned(local) * g.transpose();
    J.block<2, 2>(row, row) += R;
    J.block<2, 2>(row, a) -= R + by_direction;
    J.block<2, 2>(row, b) += by_direction;
  };
  place(0);
  for (Index row = 3; row < mean.size(); row += 2) place(row);
  framed.mean[2] = wrapAngle(mean[2] - yaw);
  J(2, 2) = 1.0;
  J.block<1, 2>(2, a) = g.transpose();
  J.block<1, 2>(2, b) = -g.transpose();

  framed.covariance = J * covariance * J.transpose();
  framed.covariance = 0.5 * (framed.covariance + framed.covariance.transpose()).eval();
  return framed;
}

}  // namespace hymm::core
