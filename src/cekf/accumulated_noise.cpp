#include "cekf/accumulated_noise.h"

#include <algorithm>

namespace hymm::core {

void AccumulatedNoise::carry(const Matrix& J, const Parts& added) {
  // By blocks: the pose's rows of J, and below them what the errors keep.
  constexpr int kPose = 3, kErrors = kStates - kPose;
  const auto J_pose = J.topRows<kPose>();
  const Eigen::Matrix<double, kErrors, 1> kept = J.diagonal().tail<kErrors>();
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Matrix& part = parts_[k];
    const Eigen::Matrix<double, kPose, kStates> JP = J_pose * part;
    part.topLeftCorner<kPose, kPose>() = JP * J_pose.transpose();
    part.topRightCorner<kPose, kErrors>() = JP.rightCols<kErrors>() * kept.asDiagonal();
    part.bottomLeftCorner<kErrors, kPose>() = part.topRightCorner<kPose, kErrors>().transpose();
    part.bottomRightCorner<kErrors, kErrors>().array() *= (kept * kept.transpose()).array();
    part += added[k];
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
