#include "hybrid_map/partition_config.h"

namespace hymm::core {

void PartitionConfig::describe(ConfigSchema& schema) {
  schema.integer("min_observations", min_observations, Range::between(1.0, 1000.0),
                 "of a landmark before it spans LTRs");
  schema.number("min_side_m", min_side_m, Range::positive(), "of a new LTR");
  schema.number("max_side_m", max_side_m, Range{0.0, 1000.0, true},
                "of a new LTR; no more than cekf_slam's landmark_block_range_m, up to which "
                "covariances of pairs are known");
  schema.number("min_angle_rad", min_angle_rad, Range{0.01, 1.0, false}, "of a new LTR");
  schema.number(
      "min_gap_height_m", min_gap_height_m, Range::positive(),
      "over the longest side; an LTR with a smaller angle than min_angle_rad is made only "
      "to fill a gap, where two or all of its sides bound LTRs already");
  schema.number("clearance_m", clearance_m, Range::notNegative(),
                "least distance of a new LTR's sides from vertices of others, so that small "
                "corrections do not make them overlap");
  schema.number("max_shape_factor", max_shape_factor, Range{1.0, 10.0, true},
                "of a new LTR: by how much a length in it may be wrong at three sigma");
  schema.number("max_stretch", max_stretch, Range{1.01, 10.0, false},
                "since an LTR was made, up or down, in any direction; beyond, it is retired");
}

}  // namespace hymm::core
