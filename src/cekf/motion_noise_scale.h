#pragma once

#include <limits>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"

namespace hymm::core {

/// By how much the motion is noisier than the vehicle's configuration claims: a factor on the
/// variance of its translation and one on that of its rotation, neither ever less than one. Their
/// logarithms are first-order Gauss-Markov processes about zero (MotionNoiseConfig), estimated by a
/// Kalman filter whose measurements are steps of Fisher scoring on the innovations.
class MotionNoiseScale {
 public:
  enum Part { kTranslation, kRotation, kParts };
  using Factors = Eigen::Matrix<double, kParts, 1>;

  /// What the innovations of a scan say about the logarithms of the factors.
  struct Evidence {
    Factors slope = Factors::Zero();  ///< of the log-likelihood, at the present factors
    Eigen::Matrix<double, kParts, kParts> information =
        Eigen::Matrix<double, kParts, kParts>::Zero();  ///< expected (Fisher's)
  };

  explicit MotionNoiseScale(const MotionNoiseConfig& config);

  /// On the variances, with which the filter predicts.
  const Factors& factors() const { return factors_; }
  /// Takes in a scan that was predicted with these factors. Evidence that is not finite is left
  /// out.
  void learn(double time_s, const Evidence& evidence);

  template <class Archive>
  void describeState(Archive& archive) {
    archive(mean_, covariance_, time_s_);
    if constexpr (Archive::kReads) {
      archive.require(mean_.allFinite() && covariance_.allFinite(),
                      "the factors on the motion's noise are not finite");
      updateFactors();
    }
  }

 private:
  using Covariance = Eigen::Matrix<double, kParts, kParts>;

  void forget(double time_s);
  void updateFactors();

  double prior_variance_;
  double memory_s_;
  Factors mean_ = Factors::Zero();  ///< of the logarithms
  Covariance covariance_;
  Factors factors_ = Factors::Ones();
  double time_s_ = -std::numeric_limits<double>::infinity();  ///< of the last evidence
};

}  // namespace hymm::core
