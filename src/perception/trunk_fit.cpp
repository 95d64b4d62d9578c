#include "perception/trunk_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

/// Each gap is cut into this many equal cells; the fit sums over all pairs of cells.
constexpr int kCells = 4;
constexpr std::size_t kHypotheses = kCells * kCells;

/// Evidence and noise in the form in which the sums below need them.
struct Beams {
  const TrunkEvidence& evidence;
  std::array<double, TrunkEvidence::kMaxHits> sines, cosines;  ///< of the offsets
  double range_variance;
  double footprint_rad;  ///< deviation of directions within a beam
  double surface_deviation;

  Beams(const TrunkEvidence& seen, const LaserNoise& noise, double shape)
      : evidence(seen),
        range_variance(noise.range_noise_m * noise.range_noise_m),
        footprint_rad(noise.beam_width_rad / std::sqrt(12.0)),
        surface_deviation(shape) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(seen.hits); ++i) {
      sines[i] = std::sin(seen.offsets_rad[i]);
      cosines[i] = std::cos(seen.offsets_rad[i]);
    }
  }
};

/// A circle of given direction b and half angle a, its distance fitted to the ranges.
struct Circle {
  Eigen::Vector3d state;       ///< range, bearing, diameter
  Eigen::Vector3d to_range;    ///< d(state)/d(range)
  Eigen::Vector3d to_bearing;  ///< d(state)/d(b)
  Eigen::Vector3d to_angle;    ///< d(state)/d(a)
  double range_variance;
  double chi_square;
  double log_density;  ///< of the ranges, up to a constant
};

/// Fits the distance p of the centre: a hit in direction d from the centre has the range p g(d),
/// g = cos d - sqrt(k^2 - sin^2 d), k = sin a. Linear in p.
Circle fitDistance(const Beams& beams, double b, double a) {
  const double sin_b = std::sin(b), cos_b = std::cos(b), k = std::sin(a), cos_a = std::cos(a);
  const double nominal_range_m = beams.evidence.nearest_m / (1.0 - k);
  const double surface_variance =
      beams.range_variance + std::pow(beams.surface_deviation * k * nominal_range_m, 2);
  const double footprint_variance = std::pow(beams.footprint_rad * nominal_range_m, 2);

  double gg = 0.0, gr = 0.0, rr = 0.0, g_ga = 0.0, g_gb = 0.0, variances = 1.0;
  double w = 1.0 / surface_variance;
  for (std::size_t i = 0; i < static_cast<std::size_t>(beams.evidence.hits); ++i) {
    // Where only the rim of a beam touches the circle, it does so at the circle's edge.
    const double sine = std::clamp(beams.sines[i] * cos_b - beams.cosines[i] * sin_b, -k, k);
    const double cosine = beams.cosines[i] * cos_b + beams.sines[i] * sin_b;
    const double root = std::sqrt(std::max(0.0, k * k - sine * sine));
    const double g = cosine - root;
    const double r = beams.evidence.ranges_m[i];
    // Derivatives grow without bound at the edge; a cell of edges averages over that.
    const double inclination = 1.0 / std::max(root, 0.2 * k);
    const double slope = sine * (cosine * inclination - 1.0);
    if (footprint_variance > 0.0) {
      const double variance = surface_variance + footprint_variance * slope * slope;
      w = 1.0 / variance;
      variances *= variance / surface_variance;
    }
    gg += w * g * g;
    gr += w * g * r;
    rr += w * r * r;
    g_ga -= w * g * inclination;
    g_gb -= w * g * slope;
  }
  g_ga *= k * cos_a;
  Circle circle;
  const double p = gr / gg, p_a = -p * g_ga / gg, p_b = -p * g_gb / gg;
  circle.state = {p, b, 2.0 * p * k};
  circle.to_range = {1.0, 0.0, 2.0 * k};
  circle.to_bearing = {p_b, 1.0, 2.0 * k * p_b};
  circle.to_angle = {p_a, 0.0, 2.0 * (k * p_a + p * cos_a)};
  circle.range_variance = 1.0 / gg;
  circle.chi_square = std::max(0.0, rr - gr * gr / gg);
  circle.log_density = -0.5 * (std::log(variances * gg) + circle.chi_square +
                               beams.evidence.hits * std::log(surface_variance));
  return circle;
}

/// What is not known within one pair of cells: the distance, and where in its cell each edge is.
Eigen::Matrix3d innerCovariance(const Circle& circle, double lower_cell, double upper_cell) {
  const Eigen::Vector3d to_lower = 0.5 * (circle.to_bearing - circle.to_angle);
  const Eigen::Vector3d to_upper = 0.5 * (circle.to_bearing + circle.to_angle);
  return circle.range_variance * circle.to_range * circle.to_range.transpose() +
         lower_cell * lower_cell / 12.0 * to_lower * to_lower.transpose() +
         upper_cell * upper_cell / 12.0 * to_upper * to_upper.transpose();
}

}  // namespace

TrunkEstimate fitTrunk(const TrunkEvidence& evidence, const LaserNoise& noise,
                       double surface_deviation) {
  const Beams beams(evidence, noise, surface_deviation);
  const double lower_cell = evidence.lower_gap_rad / kCells;
  const double upper_cell = evidence.upper_gap_rad / kCells;
  std::array<Circle, kHypotheses> circles;
  std::size_t count = 0;
  TrunkEstimate estimate;
  estimate.chi_square = std::numeric_limits<double>::infinity();
  double best_log_density = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kCells; ++i) {
    const double lower = -evidence.half_extent_rad - (i + 0.5) * lower_cell;
    for (int j = 0; j < kCells; ++j) {
      const double upper = evidence.half_extent_rad + (j + 0.5) * upper_cell;
      const double half_angle = 0.5 * (upper - lower - noise.beam_width_rad);
      if (half_angle <= 0.0 || half_angle >= 1.5) continue;
      Circle& circle = circles[count++];
      circle = fitDistance(beams, 0.5 * (lower + upper), half_angle);
      best_log_density = std::max(best_log_density, circle.log_density);
      estimate.chi_square = std::min(estimate.chi_square, circle.chi_square);
    }
  }
  if (count == 0) return estimate;

  double sum = 0.0;
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d reference = circles[0].state;  // keeps the moments free of cancellation
  for (std::size_t n = 0; n < count; ++n) {
    const double weight = std::exp(circles[n].log_density - best_log_density);
    const Eigen::Vector3d state = circles[n].state - reference;
    sum += weight;
    estimate.mean += weight * state;
    second_moment +=
        weight * (state * state.transpose() + innerCovariance(circles[n], lower_cell, upper_cell));
  }
  estimate.mean /= sum;
  estimate.covariance = second_moment / sum - estimate.mean * estimate.mean.transpose();
  estimate.mean += reference;
  return estimate;
}

}  // namespace hymm::core
