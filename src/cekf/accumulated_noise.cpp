#include "cekf/accumulated_noise.h"

#include <algorithm>

namespace hymm::core {

void AccumulatedNoise::carry(const Matrix& J, const Parts& added) {
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    parts_[k] = J * parts_[k] * J.transpose() + added[k];
  }
}

void AccumulatedNoise::multiply(double factor) {
  for (Matrix& part : parts_) part *= factor;
}

VehicleMatrix AccumulatedNoise::total(int size) const {
  VehicleMatrix total = VehicleMatrix::Zero(size, size);
  const int n = std::min(size, kStates);
  for (const Matrix& part : parts_) total.topLeftCorner(n, n) += part.topLeftCorner(n, n);
  return total;
}

MotionNoiseScale::Evidence AccumulatedNoise::evidence(const VehicleVector& score,
                                                      const VehicleMatrix& information) const {
  MotionNoiseScale::Evidence evidence;
  const Eigen::Index n = std::min<Eigen::Index>(score.size(), kStates);
  Matrix A = Matrix::Zero();
  A.topLeftCorner(n, n) = information.topLeftCorner(n, n);
  Eigen::Matrix<double, kStates, 1> b = Eigen::Matrix<double, kStates, 1>::Zero();
  b.head(n) = score.head(n);
  Parts AD;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    AD[k] = A * parts_[k];
    evidence.slope[static_cast<Eigen::Index>(k)] = 0.5 * (b.dot(parts_[k] * b) - AD[k].trace());
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    for (std::size_t j = 0; j < parts_.size(); ++j) {
      evidence.information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          0.5 * AD[i].cwiseProduct(AD[j].transpose()).sum();
    }
  }
  return evidence;
}

}  // namespace hymm::core
