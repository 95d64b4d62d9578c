// The achievable information of poses beside what an actual filter gains there: after a simulated
// drive, a sensor at random poses in the level set of 25 per m^2 looks once at the true landmarks,
// and an EKF over pose and landmarks, which knows next to nothing of the pose, takes what it sees.
// One line of CSV a pose; scripts/experiments/level_sets makes figures of it.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "common/random.h"
#include "information_map/information_map.h"
#include "support/map_history.h"

namespace hymm::test {
namespace {

using core::Pose2;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kPositionDeviation_m = 100.0;  // of the diffuse prior
constexpr double kHeadingDeviation_rad = 10.0;
constexpr double kFarthestMatch_m = 1.0;  // between a true landmark and its estimate
constexpr double kLevel = 25.0;

struct Sighting {
  Index landmark;  ///< in the map
  Vector2d z;      ///< range [m], bearing [rad]
};

struct World {
  core::LandmarkMap map;  ///< as estimated, all pairs told
  std::vector<core::TrueLandmark> truth;
};

World driveAround(unsigned seed) {
  core::SimulationConfig config;  // for the truth; simulatedHistory() drives through the same world
  config.world.name = "park";
  config.drive.laps = 2;
  config.laser.enabled = false;
  config.gps.enabled = false;
  config.detections.enabled = true;
  World world;
  world.truth = core::Simulation(config, core::simulatedCar(), seed).landmarks();
  MapHistory history = simulatedHistory("park", 2, seed, 1000.0, 60.0);
  while (auto version = history.next()) world.map = std::move(version->map);
  return world;
}

std::optional<Index> estimateOf(const core::TrueLandmark& landmark, const core::LandmarkMap& map) {
  std::optional<Index> nearest;
  double nearest_m = kFarthestMatch_m;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const double distance_m = (map.landmarks[i].position - landmark.position).norm();
    if (distance_m < nearest_m) nearest = static_cast<Index>(i);
    nearest_m = std::min(nearest_m, distance_m);
  }
  return nearest;
}

/// One look: every true landmark that the map knows, in range and in the field of view.
std::vector<Sighting> look(const World& world, const Pose2& pose,
                           const core::ExpectedSensor& sensor, core::RandomGenerator& generator) {
  std::vector<Sighting> sightings;
  for (const core::TrueLandmark& landmark : world.truth) {
    const Vector2d d = landmark.position - pose.position();
    const double bearing = core::wrapAngle(std::atan2(d.y(), d.x()) - pose.yaw_rad);
    if (d.norm() > sensor.range_m || d.norm() < sensor.min_range_m) continue;
    if (std::abs(bearing) > 0.5 * sensor.field_of_view_rad) continue;
    const auto estimate = estimateOf(landmark, world.map);
    if (!estimate) continue;
    const Vector2d z(d.norm() + core::sampleNormal(generator, sensor.range_deviation_m),
                     bearing + core::sampleNormal(generator, sensor.bearing_deviation_rad));
    sightings.push_back({*estimate, z});
  }
  return sightings;
}

/// Joint covariance of some landmarks of a map that tells all pairs.
MatrixXd jointCovariance(const core::LandmarkMap& map, const std::vector<Sighting>& sightings) {
  const auto n = Index(sightings.size());
  MatrixXd P = MatrixXd::Zero(2 * n, 2 * n);
  std::vector<Index> slot(map.landmarks.size(), -1);
  for (Index i = 0; i < n; ++i) {
    const auto landmark = std::size_t(sightings[std::size_t(i)].landmark);
    slot[landmark] = i;
    P.block<2, 2>(2 * i, 2 * i) = map.landmarks[landmark].covariance;
  }
  std::vector<Index> slot_of_id;
  for (std::size_t k = 0; k < map.landmarks.size(); ++k) {
    const auto id = std::size_t(map.landmarks[k].id);
    if (slot_of_id.size() <= id) slot_of_id.resize(id + 1, -1);
    slot_of_id[id] = slot[k];
  }
  for (const core::CrossCovariance& pair : map.cross_covariances) {
    const Index i = slot_of_id[std::size_t(pair.first_id)];
    const Index j = slot_of_id[std::size_t(pair.second_id)];
    if (i < 0 || j < 0) continue;
    P.block<2, 2>(2 * i, 2 * j) = pair.block;
    P.block<2, 2>(2 * j, 2 * i) = pair.block.transpose();
  }
  return P;
}

struct Posterior {
  Eigen::Vector3d mean;
  Matrix3d covariance;
};

/// Iterated EKF update of pose and landmarks with a diffuse pose.
Posterior update(const Pose2& guess, const std::vector<Sighting>& sightings,
                 const core::LandmarkMap& map, const core::ExpectedSensor& sensor) {
  const auto n = Index(sightings.size());
  VectorXd prior(3 + 2 * n);
  prior.head<3>() = guess.vector();
  for (Index i = 0; i < n; ++i) {
    prior.segment<2>(3 + 2 * i) =
        map.landmarks[std::size_t(sightings[std::size_t(i)].landmark)].position;
  }
  MatrixXd P = MatrixXd::Zero(3 + 2 * n, 3 + 2 * n);
  P(0, 0) = P(1, 1) = kPositionDeviation_m * kPositionDeviation_m;
  P(2, 2) = kHeadingDeviation_rad * kHeadingDeviation_rad;
  P.bottomRightCorner(2 * n, 2 * n) = jointCovariance(map, sightings);
  MatrixXd R = MatrixXd::Zero(2 * n, 2 * n);
  VectorXd x = prior;
  MatrixXd H, K;
  for (int iteration = 0; iteration < 10; ++iteration) {
    H = MatrixXd::Zero(2 * n, 3 + 2 * n);
    VectorXd residual(2 * n);
    for (Index i = 0; i < n; ++i) {
      const Vector2d d = x.segment<2>(3 + 2 * i) - x.head<2>();
      const double r = d.norm();
      Eigen::Matrix2d by_landmark;
      by_landmark << d.x() / r, d.y() / r, -d.y() / (r * r), d.x() / (r * r);
      H.block<2, 2>(2 * i, 3 + 2 * i) = by_landmark;
      H.block<2, 2>(2 * i, 0) = -by_landmark;
      H(2 * i + 1, 2) = -1.0;
      const Vector2d& z = sightings[std::size_t(i)].z;
      residual(2 * i) = z.x() - r;
      residual(2 * i + 1) = core::wrapAngle(z.y() - std::atan2(d.y(), d.x()) + x(2));
      R(2 * i, 2 * i) = std::pow(sensor.range_deviation_m, 2);
      R(2 * i + 1, 2 * i + 1) = std::pow(sensor.bearing_deviation_rad, 2);
    }
    K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
    x = prior + K * (residual - H * (prior - x));
  }
  const MatrixXd I_KH = MatrixXd::Identity(3 + 2 * n, 3 + 2 * n) - K * H;
  const MatrixXd posterior = I_KH * P * I_KH.transpose() + K * R * K.transpose();
  return {x.head<3>(), posterior.topLeftCorner<3, 3>()};
}

/// Largest eigenvalue of dY P_v: P_v <= dY^-1 where it is at most 1.
double excessOf(const Matrix3d& covariance, const Matrix3d& promised) {
  const Matrix3d root = promised.llt().matrixL();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(root.transpose() * covariance * root)
      .eigenvalues()(2);
}

void run(unsigned seed, int poses) {
  const World world = driveAround(seed);
  core::InformationMapConfig config;
  config.level_sets.values = std::to_string(kLevel);
  core::InformationMap information(config, core::VehicleConfig{});  // the sensor is at base_link
  information.apply(world.map, Pose2{});
  const core::InformationMeasure measure(config.information.measure, config.information.length_m);
  const core::ExpectedSensor& sensor = config.information.sensor;
  core::RandomGenerator generator(seed);
  std::puts(
      "x,y,yaw,predicted,predicted_landmarks,gained,gained_landmarks,excess,excess_at_estimate,"
      "nees");
  const auto& lattice = information.search().lattice();
  for (int i = 0; i < poses;) {
    const auto& around = world.map.landmarks[generator() % world.map.landmarks.size()].position;
    const Pose2 pose{around.x() + core::sampleUniform(generator, -15.0, 15.0),
                     around.y() + core::sampleUniform(generator, -15.0, 15.0),
                     core::sampleUniform(generator, -core::kPi, core::kPi)};
    if (lattice.levelAt(pose.position()) == 0) continue;
    const core::AchievableInformation predicted = information.evaluate(pose);
    const std::vector<Sighting> sightings = look(world, pose, sensor, generator);
    if (predicted.landmarks < 2 || sightings.size() < 2) continue;
    ++i;
    const Pose2 guess{pose.x_m + core::sampleNormal(generator, 0.5),
                      pose.y_m + core::sampleNormal(generator, 0.5),
                      core::wrapAngle(pose.yaw_rad + core::sampleNormal(generator, 0.05))};
    const Posterior posterior = update(guess, sightings, world.map, sensor);
    Matrix3d prior = Matrix3d::Zero();
    prior.diagonal() << 1.0 / std::pow(kPositionDeviation_m, 2),
        1.0 / std::pow(kPositionDeviation_m, 2), 1.0 / std::pow(kHeadingDeviation_rad, 2);
    const Matrix3d gained = posterior.covariance.inverse() - prior;
    // A few centimetres away, other landmarks may be certain: that is another promise.
    const core::AchievableInformation at_estimate =
        information.evaluate(Pose2::fromVector(posterior.mean));
    const double excess_at_estimate = at_estimate.landmarks == predicted.landmarks
                                          ? excessOf(posterior.covariance, at_estimate.matrix)
                                          : std::nan("");
    Eigen::Vector3d error = posterior.mean - pose.vector();
    error.z() = core::wrapAngle(error.z());
    std::printf("%.3f,%.3f,%.4f,%.6g,%d,%.6g,%zu,%.6g,%.6g,%.6g\n", pose.x_m, pose.y_m,
                pose.yaw_rad, predicted.value, predicted.landmarks, measure.of(gained),
                sightings.size(), excessOf(posterior.covariance, predicted.matrix),
                excess_at_estimate, error.dot(posterior.covariance.inverse() * error));
  }
}

}  // namespace
}  // namespace hymm::test

int main(int argc, char** argv) {
  if (argc != 3 || std::atoi(argv[1]) < 0 || std::atoi(argv[2]) < 1) {
    std::fputs("Usage: information_gain SEED POSES\n", stderr);
    return 2;
  }
  hymm::test::run(static_cast<unsigned>(std::atoi(argv[1])), std::atoi(argv[2]));
  return 0;
}
