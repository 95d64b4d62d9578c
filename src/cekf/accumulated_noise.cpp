#include "cekf/accumulated_noise.h"

namespace hymm::core {

void AccumulatedNoise::carry(const Matrix& J, const Parts& added) {
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Matrix moved = J.lazyProduct(parts_[k]);
    parts_[k] = moved.lazyProduct(J.transpose()) + added[k];
  }
}

void AccumulatedNoise::multiply(double factor) {
  for (Matrix& part : parts_) part *= factor;
}

VehicleMatrix AccumulatedNoise::total(int size) const {
  VehicleMatrix total = VehicleMatrix::Zero(size, size);
  for (const Matrix& part : parts_) total.topLeftCorner(part.rows(), part.cols()) += part;
  return total;
}

MotionNoiseScale::Evidence AccumulatedNoise::evidence(const VehicleVector& score,
                                                      const VehicleMatrix& information) const {
  MotionNoiseScale::Evidence evidence;
  const Eigen::Index n = parts_.front().rows();
  if (score.size() < n) return evidence;  // nothing was measured
  const Matrix A = information.topLeftCorner(n, n);
  const Eigen::VectorXd b = score.head(n);
  Parts AD;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    AD[k] = A.lazyProduct(parts_[k]);
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
