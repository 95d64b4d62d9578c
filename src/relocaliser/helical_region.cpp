#include "relocaliser/helical_region.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace hymm::core {
namespace {

// Rounds over all pairs end after this many tries for each particle that is wanted: where the prior
// excludes nearly all, fewer particles do.
constexpr std::size_t kTriesEach = 20;

// Of a place on a helix, beyond which a pair is not tried.
constexpr double kDeviations = 4.0;

struct Prior {
  explicit Prior(const HelicalRegions& regions) {
    if (!regions.prior) return;
    mean = regions.prior->mean;
    // A prior that is exact in some direction still has some width.
    const Eigen::Matrix3d P = regions.prior->covariance + 1e-6 * Eigen::Matrix3d::Identity();
    factor.emplace(P);
    greatest = regions.prior_deviations * regions.prior_deviations;
    reach_m = regions.prior_deviations * std::sqrt(P.topLeftCorner<2, 2>().trace());
  }
  /// Squared Mahalanobis distance; zero without a prior.
  double distance2(const Pose2& pose) const {
    if (!factor) return 0.0;
    Eigen::Vector3d d = pose.vector() - mean.vector();
    d[2] = wrapAngle(d[2]);
    return d.dot(factor->solve(d));
  }

  Pose2 mean;
  std::optional<Eigen::LLT<Eigen::Matrix3d>> factor;
  double greatest = 1.0;
  double reach_m = std::numeric_limits<double>::infinity();  ///< of its places from the mean
};

/// An observation and a landmark that it may be of.
struct Pair {
  Eigen::Vector2d landmark;
  Eigen::Vector2d p_base_point;
  Eigen::Matrix2d root;  ///< root * root' is the covariance of what (39) does to the place, m^2
};

/// Pairs whose helix comes through the prior.
std::vector<Pair> findPairs(const HelicalRegions& regions, const Prior& prior) {
  std::vector<Pair> pairs;
  for (const ObservedPoint& point : regions.points) {
    const Eigen::Vector2d p_base_point = point.p_base_point.cast<double>();
    for (const LocalLandmark& landmark : regions.landmarks) {
      const Eigen::Matrix2d S =
          landmark.covariance + point.deviation_m * point.deviation_m * Eigen::Matrix2d::Identity();
      const double away_m = (landmark.position - prior.mean.position()).norm();
      const double reach_m = prior.reach_m + kDeviations * std::sqrt(S.trace());
      if (std::abs(away_m - p_base_point.norm()) > reach_m) continue;
      pairs.push_back({landmark.position, p_base_point, S.llt().matrixL()});
    }
  }
  return pairs;
}

/// Log weight of a sampled pose but for the prior; nothing if no observation falls near a landmark.
std::optional<double> logWeight(const Pose2& pose, const std::vector<ObservedPoint>& points,
                                const DensityMap& density) {
  double log_likelihood = 0.0, proposal = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double value = density.logValueAt(k, pose * points[k].p_base_point.cast<double>());
    log_likelihood += value;
    proposal += std::expm1(value);
  }
  if (proposal <= 0.0) return std::nullopt;
  return log_likelihood - std::log(proposal);
}

}  // namespace

Pose2 poseOnHelix(const Eigen::Vector2d& landmark, const Eigen::Vector2d& p_base_point,
                  double heading_rad) {
  const Pose2 turned{0.0, 0.0, wrapAngle(heading_rad)};
  const Eigen::Vector2d place = landmark - turned * p_base_point;
  return {place.x(), place.y(), turned.yaw_rad};
}

ParticleSet sampleHelicalRegions(const HelicalRegions& regions, const DensityMap& density,
                                 std::size_t count, RandomGenerator& generator) {
  ParticleSet particles;
  particles.reserve(count);
  const Prior prior(regions);
  const std::vector<Pair> pairs = findPairs(regions, prior);
  if (pairs.empty()) return particles;
  const double half_width = std::min(kPi, regions.headings.half_width_rad);
  for (std::size_t tries = 0; particles.size() < count && tries < kTriesEach * count; ++tries) {
    const Pair& pair = pairs[tries % pairs.size()];
    const Eigen::Vector2d error(sampleNormal(generator, 1.0), sampleNormal(generator, 1.0));
    const double heading =
        regions.headings.centre_rad + sampleUniform(generator, -half_width, half_width);
    const Pose2 pose = poseOnHelix(pair.landmark + pair.root * error, pair.p_base_point, heading);
    const double distance2 = prior.distance2(pose);
    if (distance2 > prior.greatest) continue;
    if (const auto weight = logWeight(pose, regions.points, density)) {
      particles.add(pose, static_cast<float>(*weight - 0.5 * distance2));
    }
  }
  return particles;
}

}  // namespace hymm::core
