#include "cekf/motion_noise_scale.h"

#include <cmath>

#include <Eigen/LU>

namespace hymm::core {
namespace {

// Deviations ten times as large as claimed: beyond that the claim is a mistake of units.
constexpr double kLargestFactor = 100.0;

double square(double value) { return value * value; }

}  // namespace

MotionNoiseScale::MotionNoiseScale(const MotionNoiseConfig& config)
    : prior_variance_(square(2.0 * std::log1p(config.doubt))),
      memory_s_(config.memory_s),
      covariance_(prior_variance_ * Covariance::Identity()) {}

void MotionNoiseScale::learn(double time_s, const Evidence& evidence) {
  const bool is_finite = evidence.slope.allFinite() && evidence.information.allFinite();
  if (!(prior_variance_ > 0.0) || !is_finite) return;
  forget(time_s);
  const Covariance before = covariance_.inverse();
  // The log-likelihood is far from a parabola where the innovations are much larger than predicted:
  // there its slope falls off as fast as it is large.
  Covariance curvature = before + evidence.information;
  curvature.diagonal() += evidence.slope.cwiseMax(0.0);
  const Factors predicted_with = factors_.array().log();
  mean_ += curvature.inverse() * (evidence.slope + evidence.information * (predicted_with - mean_));
  covariance_ = Covariance(before + evidence.information).inverse();
  updateFactors();
}

void MotionNoiseScale::forget(double time_s) {
  const double elapsed_s = std::isfinite(time_s_) ? std::fmax(0.0, time_s - time_s_) : 0.0;
  const double kept = std::exp(-elapsed_s / memory_s_);
  mean_ *= kept;
  covariance_ =
      kept * kept * covariance_ + (1.0 - kept * kept) * prior_variance_ * Covariance::Identity();
  time_s_ = time_s;
}

void MotionNoiseScale::updateFactors() {
  factors_ = mean_.array().exp().cwiseMax(1.0).cwiseMin(kLargestFactor);
}

}  // namespace hymm::core
