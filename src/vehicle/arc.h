#pragma once

#include <cmath>

#include <Eigen/Core>

namespace hymm::core {

/// Displacement along an arc: a body that moves at constant velocity (forward, lateral) over a
/// time in which it turns by `turn_rad` is displaced by `V() * velocity * time` in its first axes.
class Arc {
 public:
  explicit Arc(double turn_rad) {
    const double t = turn_rad;
    if (std::abs(t) < kSmallTurn_rad) {
      const double t2 = t * t;
      sine_ = 1.0 - t2 / 6.0 * (1.0 - t2 / 20.0);
      versine_ = t / 2.0 * (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0));
      d_sine_ = -t / 3.0 * (1.0 - t2 / 10.0 * (1.0 - t2 / 28.0));
      d_versine_ = 0.5 - t2 / 8.0 * (1.0 - t2 / 18.0);
    } else {
      const double half = std::sin(0.5 * t);
      sine_ = std::sin(t) / t;
      versine_ = 2.0 * half * half / t;  // 1 - cos(t) without cancellation
      d_sine_ = (std::cos(t) - sine_) / t;
      d_versine_ = (std::sin(t) - versine_) / t;
    }
  }

  Eigen::Matrix2d V() const {
    return (Eigen::Matrix2d() << sine_, -versine_, versine_, sine_).finished();
  }

  /// Derivative of V by the turn.
  Eigen::Matrix2d dV() const {
    return (Eigen::Matrix2d() << d_sine_, -d_versine_, d_versine_, d_sine_).finished();
  }

  /// d(x, y, yaw)/d(forward, lateral, yaw rate) of a step of `duration_s` from the origin;
  /// `chord` is velocity * duration [m].
  Eigen::Matrix3d velocityJacobian(const Eigen::Vector2d& chord, double duration_s) const {
    Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
    J.topLeftCorner<2, 2>() = V() * duration_s;
    J.topRightCorner<2, 1>() = dV() * chord * duration_s;
    J(2, 2) = duration_s;
    return J;
  }

 private:
  // Below this turn the series are exact to rounding; above it the quotients lose no more than
  // three digits of a derivative that is itself that small.
  static constexpr double kSmallTurn_rad = 1e-2;

  double sine_;     // sin(t) / t
  double versine_;  // (1 - cos(t)) / t
  double d_sine_;
  double d_versine_;
};

}  // namespace hymm::core
