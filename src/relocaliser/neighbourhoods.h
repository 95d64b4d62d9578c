#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/landmark_map.h"
#include "common/config.h"
#include "relocaliser/local_map.h"

namespace hymm::core {

/// How a whole map is covered by local maps, for a vehicle that may be anywhere in it.
struct NeighbourhoodConfig {
  double spacing_m = 20.0;  ///< between the middles of two local maps, at least
  int most = 300;           ///< local maps
  double restart_s = 10.0;  ///< after which a search that has not converged begins anew

  void describe(ConfigSchema& schema);
};

/// Where local maps have their middles that together cover all landmarks: each within `spacing_m`
/// of one, and each of them a landmark, so that from any place where landmarks are in view one of
/// the maps holds most of what is seen; neighbours overlap.
std::vector<Eigen::Vector2d> findMiddles(const std::vector<LandmarkEstimate>& landmarks,
                                         double spacing_m);

/// Ids, ascending, of the landmarks around a middle that tryMakeNeighbourhood() needs.
std::vector<int> landmarksAround(const Eigen::Vector2d& middle,
                                 const std::vector<LandmarkEstimate>& landmarks,
                                 const LocalMapConfig& config);

/// The local map of the landmarks around a middle. Nothing, and the reason in `problem`, if fewer
/// than two of them know each other.
std::optional<LocalMap> tryMakeNeighbourhood(const JointLandmarks& landmarks,
                                             const Eigen::Vector2d& middle, double spacing_m,
                                             const LocalMapConfig& config, std::string& problem);

}  // namespace hymm::core
