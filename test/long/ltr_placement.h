#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "hybrid_map/hybrid_map.h"
#include "simulation/simulation.h"

namespace hymm::core {

/// How exactly what a scan writes is placed relative to the LTR that it falls into: the error of a
/// place that the vehicle sees, less what the LTR's vertices have of it by (6). That is what stays
/// in the dense map for good, whatever becomes of the landmarks; the rest moves away with them.
class LtrPlacement {
 public:
  /// Looks, after a scan was written, at the middle of each LTR that its beams can reach.
  void look(const HybridMap& map, CekfSlam& filter, const Pose2& T_map_base,
            const Pose2& T_map_base_true, double range_m);

  /// Figures a line, as JSON: `"PREFIX_...": value,`. Landmarks are taken for those of the truth
  /// that are nearest to where they ended.
  std::string text(const std::string& prefix, const LandmarkMap& last,
                   const std::vector<TrueLandmark>& truth) const;

 private:
  struct Look {
    double distance_m;
    double deviation_m;  ///< as the filter has it, relative to the vertices
    std::array<int, 3> vertices;
    Eigen::Vector2d place_error;  ///< in map
    std::array<Eigen::Vector2d, 3> vertices_then;
  };

  std::vector<Look> looks_;
};

}  // namespace hymm::core
