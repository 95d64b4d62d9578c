#include "relocaliser/neighbourhoods.h"

#include <algorithm>
#include <utility>

namespace hymm::core {
namespace {

using Eigen::Vector2d;

// Of a vehicle that may be anywhere: so large that no landmark counts as known relative to it.
constexpr double kAnywhere_m = 1e3;

// Landmarks asked for, for each that the map may hold: some are known too little to be taken.
constexpr std::size_t kAskedEach = 3;

}  // namespace

void NeighbourhoodConfig::describe(ConfigSchema& schema) {
  schema.number("spacing_m", spacing_m, Range{1.0, 1000.0},
                "between the middles of two local maps, at least; less than the sensor's range");
  schema.integer("most", most, Range::between(1, 100000),
                 "local maps that a search may take; a larger map is not searched without a prior");
  schema.number("restart_s", restart_s, Range{1.0, 3600.0},
                "after which a search that has not converged begins anew");
}

std::vector<Vector2d> findMiddles(const std::vector<LandmarkEstimate>& landmarks,
                                  double spacing_m) {
  std::vector<Vector2d> middles;
  for (const LandmarkEstimate& landmark : landmarks) {
    const bool is_covered = std::any_of(middles.begin(), middles.end(), [&](const Vector2d& other) {
      return (landmark.position - other).norm() < spacing_m;
    });
    if (!is_covered) middles.push_back(landmark.position);
  }
  return middles;
}

std::vector<int> landmarksAround(const Vector2d& middle,
                                 const std::vector<LandmarkEstimate>& landmarks,
                                 const LocalMapConfig& config) {
  std::vector<std::pair<double, int>> near;
  for (const LandmarkEstimate& landmark : landmarks) {
    near.emplace_back((landmark.position - middle).squaredNorm(), landmark.id);
  }
  std::sort(near.begin(), near.end());
  near.resize(std::min(near.size(), kAskedEach * static_cast<std::size_t>(config.max_landmarks)));
  std::vector<int> ids;
  for (const auto& [distance2, id] : near) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::optional<LocalMap> tryMakeNeighbourhood(const JointLandmarks& landmarks,
                                             const Vector2d& middle, double spacing_m,
                                             const LocalMapConfig& config, std::string& problem) {
  LocalMapConfig around = config;
  around.travel_m = 0.0;
  VehicleAmongLandmarks estimate;
  estimate.landmarks = landmarks;
  estimate.vehicle.mean = {middle.x(), middle.y(), 0.0};
  estimate.vehicle.covariance =
      Eigen::Vector3d(kAnywhere_m * kAnywhere_m, kAnywhere_m * kAnywhere_m, kPi * kPi).asDiagonal();
  return tryMakeLocalMap(estimate, spacing_m, around, problem);
}

}  // namespace hymm::core
