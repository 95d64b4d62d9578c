#include "relocaliser/neighbourhoods.h"

#include <algorithm>
#include <string>
#include <utility>

namespace hymm::core {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

// Of a vehicle that may be anywhere: so large that no landmark counts as known relative to it.
constexpr double kAnywhere_m = 1e3;

}  // namespace

std::vector<LocalMap> makeNeighbourhoods(const JointLandmarks& landmarks, double spacing_m,
                                         const LocalMapConfig& config) {
  LocalMapConfig around = config;
  around.travel_m = 0.0;
  VehicleAmongLandmarks estimate;
  estimate.landmarks = landmarks;
  estimate.vehicle.covariance =
      Eigen::Vector3d(kAnywhere_m * kAnywhere_m, kAnywhere_m * kAnywhere_m, kPi * kPi).asDiagonal();
  std::vector<Vector2d> middles;
  std::vector<LocalMap> maps;
  for (Index row = 0; row + 1 < landmarks.mean.size(); row += 2) {
    const Vector2d middle = landmarks.mean.segment<2>(row);
    const bool is_covered = std::any_of(middles.begin(), middles.end(), [&](const Vector2d& other) {
      return (middle - other).norm() < spacing_m;
    });
    if (is_covered) continue;
    middles.push_back(middle);
    estimate.vehicle.mean = {middle.x(), middle.y(), 0.0};
    std::string problem;
    if (auto map = tryMakeLocalMap(estimate, spacing_m, around, problem)) {
      maps.push_back(std::move(*map));
    }
  }
  return maps;
}

}  // namespace hymm::core
