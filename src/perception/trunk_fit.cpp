#include "perception/trunk_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

/// Gauss-Legendre nodes and weights on [0, 1].
constexpr int kNodes = 3;
constexpr std::array<double, kNodes> kPlace = {0.112701665379258, 0.5, 0.887298334620742};
constexpr std::array<double, kNodes> kWeight = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

/// A circle of given direction and angular size, its distance fitted to the ranges.
struct CircleHypothesis {
  double bearing_rad = 0.0;
  double sine_half_angle = 0.0;  ///< radius / range of the centre
  double range_m = 0.0;
  double range_variance = 0.0;
  double chi_square = 0.0;
  double log_density = 0.0;  ///< of the ranges, up to a constant
};

/// Fits the distance: a hit at angle d from the centre has range g(d) * range of the centre, with
/// g = cos d - sqrt(k^2 - sin^2 d) and k the sine of the half angle.
CircleHypothesis fitDistance(const TrunkEvidence& evidence, const LaserNoise& noise,
                             double shape_deviation, double bearing_rad, double half_angle_rad) {
  const double k = std::sin(half_angle_rad);
  const double nominal_range_m = evidence.nearest_m / (1.0 - k);
  const double shape_m = shape_deviation * k * nominal_range_m;
  const double range_variance = noise.range_noise_m * noise.range_noise_m + shape_m * shape_m;
  const double footprint_m = nominal_range_m * noise.beam_width_rad / std::sqrt(12.0);

  double sum_gg = 0.0, sum_gr = 0.0, sum_rr = 0.0, log_density = 0.0;
  for (int i = 0; i < evidence.hits; ++i) {
    const auto at = static_cast<std::size_t>(i);
    // Beyond the circle only the beam's rim touches it: at the edge, where the range is greatest.
    const double offset =
        std::clamp(evidence.offsets_rad[at] - bearing_rad, -half_angle_rad, half_angle_rad);
    const double sine = std::sin(offset);
    const double cosine = std::sqrt(1.0 - sine * sine);
    const double root = std::sqrt(std::max(0.0, k * k - sine * sine));
    const double g = cosine - root;
    // A beam of finite width meets a range of depths where the surface is inclined.
    const double slope = std::min(std::abs(sine) / std::max(root, 1e-9), 10.0);
    const double variance = range_variance + std::pow(footprint_m * slope, 2);
    const double weight = 1.0 / variance;
    sum_gg += weight * g * g;
    sum_gr += weight * g * evidence.ranges_m[at];
    sum_rr += weight * evidence.ranges_m[at] * evidence.ranges_m[at];
    log_density -= 0.5 * std::log(variance);
  }
  CircleHypothesis circle;
  circle.bearing_rad = bearing_rad;
  circle.sine_half_angle = k;
  circle.range_m = sum_gr / sum_gg;
  circle.range_variance = 1.0 / sum_gg;
  circle.chi_square = std::max(0.0, sum_rr - sum_gr * sum_gr / sum_gg);
  circle.log_density = log_density - 0.5 * std::log(sum_gg) - 0.5 * circle.chi_square;
  return circle;
}

}  // namespace

TrunkEstimate fitTrunk(const TrunkEvidence& evidence, const LaserNoise& noise,
                       double shape_deviation) {
  std::array<CircleHypothesis, kNodes * kNodes> circles;
  std::array<double, kNodes * kNodes> priors;
  std::size_t count = 0;
  TrunkEstimate estimate;
  estimate.chi_square = std::numeric_limits<double>::infinity();
  double best_log_density = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kNodes; ++i) {
    const double lower = -evidence.half_extent_rad - kPlace[i] * evidence.lower_gap_rad;
    for (std::size_t j = 0; j < kNodes; ++j) {
      const double upper = evidence.half_extent_rad + kPlace[j] * evidence.upper_gap_rad;
      const double half_angle = 0.5 * (upper - lower - noise.beam_width_rad);
      if (half_angle <= 0.0 || half_angle >= 1.5) continue;
      circles[count] =
          fitDistance(evidence, noise, shape_deviation, 0.5 * (lower + upper), half_angle);
      priors[count] = kWeight[i] * kWeight[j];
      best_log_density = std::max(best_log_density, circles[count].log_density);
      estimate.chi_square = std::min(estimate.chi_square, circles[count].chi_square);
      ++count;
    }
  }
  if (count == 0) return estimate;

  double sum = 0.0;
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();
  const double reference_m = circles[0].range_m;  // keeps the moments free of cancellation
  for (std::size_t n = 0; n < count; ++n) {
    const CircleHypothesis& circle = circles[n];
    const double weight = priors[n] * std::exp(circle.log_density - best_log_density);
    const double scale = 2.0 * circle.sine_half_angle;  // diameter / range
    const Eigen::Vector3d state(circle.range_m - reference_m, circle.bearing_rad,
                                scale * circle.range_m);
    const Eigen::Vector3d along(1.0, 0.0, scale);
    sum += weight;
    estimate.mean += weight * state;
    second_moment +=
        weight * (state * state.transpose() + circle.range_variance * along * along.transpose());
  }
  estimate.mean /= sum;
  estimate.covariance = second_moment / sum - estimate.mean * estimate.mean.transpose();
  estimate.mean[0] += reference_m;
  return estimate;
}

}  // namespace hymm::core
