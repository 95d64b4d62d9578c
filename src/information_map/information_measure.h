#pragma once

#include <string>

#include <Eigen/Core>

namespace hymm::core {

/// The scalar that a 3x3 information on a pose (x, y, heading) is judged by. Metres and radians are
/// brought together by S = diag(1, 1, 1/length): S * Y * S is in 1/m^2, and so is the measure.
class InformationMeasure {
 public:
  /// `name`: determinant (its cube root), smallest_eigenvalue or trace. Throws ConfigError for
  /// another.
  InformationMeasure(const std::string& name, double length_m);

  /// Not negative. The determinant and the smallest eigenvalue of an information that leaves a
  /// direction free are 0, to rounding.
  double of(const Eigen::Matrix3d& information) const;

 private:
  enum class Kind { kDeterminant, kSmallestEigenvalue, kTrace };
  Kind kind_;
  Eigen::Vector3d scale_;
};

}  // namespace hymm::core
