#pragma once

#include <array>
#include <vector>

#include "cekf/landmark_map.h"
#include "hybrid_map/ltr_partition.h"

namespace hymm::core {

/// One LTR without its geometry: whoever has the landmark map has that.
struct LtrTopology {
  int id = kNone;
  std::array<int, 3> landmark_ids{};  ///< counter-clockwise; the first is L_1 of (2)
  std::array<int, 3> neighbours{kNone, kNone, kNone};  ///< across sides (0,1), (1,2), (2,0)
  int alpha_cells = 0, beta_cells = 0;                 ///< of its grid
  double observations = 0.0;
  double shape_factor = 1.0;  ///< NaN where a covariance between its vertices is not told
};

/// All LTRs of a partition by ascending id, without their grids, with the shape factors that the
/// covariances of `map` give.
std::vector<LtrTopology> topologyOf(const LtrPartition& partition, const LandmarkMap& map);

}  // namespace hymm::core
