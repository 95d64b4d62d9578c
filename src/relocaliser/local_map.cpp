#include "relocaliser/local_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/LU>

#include "relocaliser/block_bound.h"

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// A radian of heading weighs as much as this many metres where one number has to stand for a pose:
// what it moves at half a laser's range.
constexpr double kLever_m = 10.0;

// Landmarks among which the frame is chosen, however few are near.
constexpr int kFewestForFrame = 10;

std::string findProblem(const VehicleAmongLandmarks& estimate) {
  const auto states = static_cast<Index>(2 * estimate.landmarks.ids.size());
  const MatrixXd& cross = estimate.cross_covariance;
  if (estimate.landmarks.mean.size() != states || estimate.landmarks.covariance.rows() != states ||
      estimate.landmarks.covariance.cols() != states ||
      (cross.size() > 0 && (cross.rows() != 3 || cross.cols() != states))) {
    return "The joint estimate of the landmarks has the wrong size.";
  }
  if (!estimate.landmarks.mean.allFinite() || !estimate.landmarks.covariance.allFinite() ||
      !cross.allFinite() || !estimate.vehicle.mean.vector().allFinite() ||
      !estimate.vehicle.covariance.allFinite()) {
    return "The joint estimate of the landmarks is not finite.";
  }
  if (states < 4) {
    return "The map has " + std::to_string(states / 2) +
           " landmark(s) near the vehicle; to find a place takes two at least.";
  }
  return {};
}

/// Pose and landmarks as one Gaussian, map frame.
struct Joint {
  std::vector<int> ids;
  VectorXd mean;
  MatrixXd covariance;
};

Joint jointOf(const VehicleAmongLandmarks& estimate) {
  const Index states = estimate.landmarks.mean.size();
  Joint joint{estimate.landmarks.ids, VectorXd(3 + states), MatrixXd::Zero(3 + states, 3 + states)};
  joint.mean << estimate.vehicle.mean.vector(), estimate.landmarks.mean;
  joint.covariance.topLeftCorner<3, 3>() = estimate.vehicle.covariance;
  joint.covariance.bottomRightCorner(states, states) = estimate.landmarks.covariance;
  if (estimate.cross_covariance.size() > 0) {
    joint.covariance.topRightCorner(3, states) = estimate.cross_covariance;
    joint.covariance.bottomLeftCorner(states, 3) = estimate.cross_covariance.transpose();
  }
  return joint;
}

/// The same of the landmarks at `kept` only.
Joint reduced(const Joint& joint, const std::vector<std::size_t>& kept) {
  std::vector<Index> states{0, 1, 2};
  Joint result;
  for (const std::size_t i : kept) {
    result.ids.push_back(joint.ids[i]);
    states.push_back(3 + 2 * static_cast<Index>(i));
    states.push_back(states.back() + 1);
  }
  result.mean = joint.mean(states);
  result.covariance = joint.covariance(states, states);
  return result;
}

/// Variance (trace) of the way between two places of the joint estimate, by their first states,
/// m^2.
double relativeVariance(const Joint& joint, Index a, Index b) {
  const MatrixXd& P = joint.covariance;
  return (P.block<2, 2>(a, a) + P.block<2, 2>(b, b) - P.block<2, 2>(a, b) - P.block<2, 2>(b, a))
      .trace();
}

Index rowOf(std::size_t landmark) { return 3 + 2 * static_cast<Index>(landmark); }

/// Distance from the way that the vehicle may drive on meanwhile, as its heading leads, in units of
/// what the landmark's place relative to the vehicle's is uncertain by, and of what is seen anyway.
/// By the distance alone, a wrong place would choose landmarks of its own surroundings.
double remoteness(const Joint& joint, std::size_t landmark, double range_m,
                  const LocalMapConfig& config) {
  const Vector2d ahead(std::cos(joint.mean[2]), std::sin(joint.mean[2]));
  const Vector2d arm = joint.mean.segment<2>(rowOf(landmark)) - joint.mean.head<2>();
  const double along_m = std::clamp(ahead.dot(arm), 0.0, config.travel_m);
  const double variance_m2 = relativeVariance(joint, 0, rowOf(landmark));
  return (arm - along_m * ahead).norm() / std::sqrt(range_m * range_m + variance_m2);
}

/// Those that the sensor may see from somewhere in the prior.
std::vector<std::size_t> withinReach(const Joint& joint, double range_m,
                                     const LocalMapConfig& config) {
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < joint.ids.size(); ++i) {
    const double spread_m =
        config.prior_deviations * std::sqrt(relativeVariance(joint, 0, rowOf(i)));
    const double distance_m = (joint.mean.segment<2>(rowOf(i)) - joint.mean.head<2>()).norm();
    if (distance_m <= range_m + config.travel_m + spread_m) near.push_back(i);
  }
  return near;
}

/// Landmarks that came along with the vehicle do not tell where both are: if there are others that
/// know each other, these are the map.
void dropCarried(const Joint& joint, const LocalMapConfig& config,
                 std::vector<std::size_t>& landmarks) {
  const double known_m2 = 2.0 * config.max_landmark_deviation_m * config.max_landmark_deviation_m;
  std::vector<std::size_t> others;
  for (const std::size_t i : landmarks) {
    if (relativeVariance(joint, 0, rowOf(i)) > known_m2) others.push_back(i);
  }
  const auto isKnownToAnother = [&](std::size_t i) {
    return std::any_of(others.begin(), others.end(), [&](std::size_t j) {
      return i != j && relativeVariance(joint, rowOf(i), rowOf(j)) <= known_m2;
    });
  };
  if (std::any_of(others.begin(), others.end(), isKnownToAnother)) landmarks = others;
}

void keepNearest(const Joint& joint, int count, double range_m, const LocalMapConfig& config,
                 std::vector<std::size_t>& landmarks) {
  const auto limit = static_cast<std::size_t>(count);
  if (landmarks.size() <= limit) return;
  std::stable_sort(landmarks.begin(), landmarks.end(), [&](std::size_t a, std::size_t b) {
    return remoteness(joint, a, range_m, config) < remoteness(joint, b, range_m, config);
  });
  landmarks.resize(limit);
  std::sort(landmarks.begin(), landmarks.end());
}

/// The half of the landmarks that is nearest, ten at least: what is far away may hang together just
/// as well, but is not where the vehicle is looked for.
std::vector<int> nearerHalf(const Joint& joint, double range_m, const LocalMapConfig& config) {
  std::vector<std::size_t> landmarks(joint.ids.size());
  std::iota(landmarks.begin(), landmarks.end(), 0U);
  keepNearest(joint, std::max(kFewestForFrame, static_cast<int>(landmarks.size() / 2)), range_m,
              config, landmarks);
  std::vector<int> half;
  for (const std::size_t i : landmarks) half.push_back(static_cast<int>(i));
  return half;
}

/// The bound of vehicle and landmarks. The vehicle, known least, takes most of what its correlation
/// with the landmarks costs: all are inflated by the same share.
MatrixXd boundOf(const MatrixXd& covariance) {
  const Index n = (covariance.rows() - 3) / 2;
  // The heading is scaled to metres while singular values are taken.
  Eigen::VectorXd scale = VectorXd::Ones(covariance.rows());
  scale[2] = kLever_m;
  const MatrixXd scaled = scale.asDiagonal() * covariance * scale.asDiagonal();
  const double of_vehicle = scaled.topLeftCorner<3, 3>().trace();
  const double of_landmark = scaled.diagonal().tail(2 * n).sum() / static_cast<double>(n);
  std::vector<CovarianceBlock> blocks(static_cast<std::size_t>(n) + 1);
  blocks.front().size = 3;
  if (of_landmark > 0.0 && of_vehicle > of_landmark) {
    blocks.front().weight = std::sqrt(of_vehicle / of_landmark);
  }
  const VectorXd back = scale.cwiseInverse();
  return back.asDiagonal() * computeBlockBound(scaled, blocks) * back.asDiagonal();
}

/// Index of the landmark with the greatest deviation, if that is over the limit.
std::optional<std::size_t> findVaguest(const MatrixXd& bound, double max_deviation_m) {
  std::optional<std::size_t> vaguest;
  double greatest = max_deviation_m * max_deviation_m;
  for (Index row = 3; row < bound.rows(); row += 2) {
    const Matrix2d block = bound.block<2, 2>(row, row);
    const double half = 0.5 * block.trace();
    const double variance = half + std::sqrt(std::max(0.0, half * half - block.determinant()));
    if (variance <= greatest) continue;
    greatest = variance;
    vaguest = static_cast<std::size_t>((row - 3) / 2);
  }
  return vaguest;
}

LocalMap makeLocalMap(const Joint& joint, const FramedEstimate& framed, const MatrixXd& bound) {
  LocalMap map;
  map.T_map_local = framed.T_map_local;
  map.vehicle = {Pose2::fromVector(framed.mean.head<3>()), bound.topLeftCorner<3, 3>()};
  for (std::size_t i = 0; i < joint.ids.size(); ++i) {
    const Index row = 3 + 2 * static_cast<Index>(i);
    map.landmarks.push_back(
        {joint.ids[i], framed.mean.segment<2>(row), bound.block<2, 2>(row, row)});
  }
  return map;
}

std::vector<std::size_t> allBut(std::size_t count, std::size_t left_out) {
  std::vector<std::size_t> kept(count);
  std::iota(kept.begin(), kept.end(), 0U);
  kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(left_out));
  return kept;
}

}  // namespace

void LocalMapConfig::describe(ConfigSchema& schema) {
  schema.integer("max_landmarks", max_landmarks, Range::between(2, 100),
                 "most landmarks in the map of a relocalisation, the nearest");
  schema.number("prior_deviations", prior_deviations, Range::between(1.0, 10.0),
                "deviations of the vehicle's place that the map covers");
  schema.number("travel_m", travel_m, Range::notNegative(),
                "way that the vehicle may drive before it is found, and that the map covers");
  schema.number("max_landmark_deviation_m", max_landmark_deviation_m, Range::positive(),
                "a landmark with a greater deviation in the local frame is left out");
}

std::optional<LocalMap> tryMakeLocalMap(const VehicleAmongLandmarks& estimate, double range_m,
                                        const LocalMapConfig& config, std::string& problem) {
  problem = findProblem(estimate);
  if (!problem.empty()) return std::nullopt;
  Joint joint = jointOf(estimate);
  std::vector<std::size_t> kept = withinReach(joint, range_m, config);
  dropCarried(joint, config, kept);
  keepNearest(joint, config.max_landmarks, range_m, config, kept);
  joint = reduced(joint, kept);
  while (joint.ids.size() >= 2) {
    const Index states = 2 * static_cast<Index>(joint.ids.size());
    const FrameChoice frame = computeBestFrame(joint.mean.tail(states),
                                               joint.covariance.bottomRightCorner(states, states),
                                               nearerHalf(joint, range_m, config));
    const FramedEstimate framed =
        expressInFrame(joint.mean, joint.covariance, frame.origin, frame.axis);
    const MatrixXd bound = boundOf(framed.covariance);
    const auto vaguest = findVaguest(bound, config.max_landmark_deviation_m);
    if (!vaguest) {
      LocalMap map = makeLocalMap(joint, framed, bound);
      map.version = estimate.landmarks.version;
      map.origin_id = joint.ids[static_cast<std::size_t>(frame.origin)];
      map.axis_id = joint.ids[static_cast<std::size_t>(frame.axis)];
      return map;
    }
    joint = reduced(joint, allBut(joint.ids.size(), *vaguest));
  }
  problem = "Fewer than two landmarks near the vehicle are known to " +
            std::to_string(config.max_landmark_deviation_m) +
            " m of each other; there is nothing to find a place by.";
  return std::nullopt;
}

}  // namespace hymm::core
