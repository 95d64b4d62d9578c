#include "information_map/information_measure.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "common/error.h"

namespace hymm::core {
namespace {

// Of the largest eigenvalue: what is below is rounding.
constexpr double kRounding = 1e-13;

}  // namespace

InformationMeasure::InformationMeasure(const std::string& name, double length_m)
    : scale_(1.0, 1.0, 1.0 / length_m) {
  if (name == "determinant") {
    kind_ = Kind::kDeterminant;
  } else if (name == "smallest_eigenvalue") {
    kind_ = Kind::kSmallestEigenvalue;
  } else if (name == "trace") {
    kind_ = Kind::kTrace;
  } else {
    throw ConfigError({"measure: '" + name +
                       "' is not known; choose determinant, smallest_eigenvalue or trace."});
  }
}

double InformationMeasure::of(const Eigen::Matrix3d& information) const {
  const Eigen::Matrix3d scaled = scale_.asDiagonal() * information * scale_.asDiagonal();
  const double trace = scaled.trace();
  if (kind_ == Kind::kTrace) return std::max(0.0, trace);
  if (kind_ == Kind::kDeterminant) {
    const double determinant = scaled.determinant();
    return determinant > kRounding * trace * trace * trace ? std::cbrt(determinant) : 0.0;
  }
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues(0) > kRounding * eigenvalues(2) ? eigenvalues(0) : 0.0;
}

}  // namespace hymm::core
