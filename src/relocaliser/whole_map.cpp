#include "relocaliser/whole_map.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace hymm::core {
namespace {

bool isUsable(const LandmarkEstimate& landmark, const WholeMapConfig& config) {
  const Eigen::Matrix2d& P = landmark.covariance;
  const double half = 0.5 * P.trace();
  const double variance = half + std::sqrt(std::max(0.0, half * half - P.determinant()));
  return landmark.position.allFinite() && P.allFinite() && P.determinant() > 0.0 &&
         landmark.observations >= config.least_observations &&
         variance <= config.max_deviation_m * config.max_deviation_m;
}

}  // namespace

void WholeMapConfig::describe(ConfigSchema& schema) {
  schema.integer("least_observations", least_observations, Range::between(1, 1000),
                 "a landmark that was observed less often is left out");
  schema.number("max_deviation_m", max_deviation_m, Range::positive(),
                "a landmark with a greater deviation in the map frame is left out");
}

std::optional<LocalMap> tryMakeWholeMap(const std::vector<LandmarkEstimate>& landmarks,
                                        const WholeMapConfig& config, std::string& problem) {
  LocalMap map;
  for (const LandmarkEstimate& landmark : landmarks) {
    if (isUsable(landmark, config)) {
      map.landmarks.push_back({landmark.id, landmark.position, landmark.covariance});
    }
  }
  if (map.landmarks.size() < 2) {
    problem = "The map has " + std::to_string(map.landmarks.size()) +
              " landmark(s) that are known well; to find a place takes two at least.";
    return std::nullopt;
  }
  map.origin_id = map.landmarks.front().id;
  map.axis_id = map.landmarks.back().id;
  return map;
}

}  // namespace hymm::core
