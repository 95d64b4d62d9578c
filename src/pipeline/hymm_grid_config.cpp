#include "pipeline/hymm_grid_config.h"

namespace hymm::core {

void HymmGridConfig::describe(ConfigSchema& schema) {
  map.describe(schema);
  schema.text("scan_input", scan_input,
              "topic that brings what is written; where cekf_slam's observation_input is scan or "
              "points, the same",
              {"scan", "points"});
  schema.number("min_range_m", min_range_m, Range::notNegative(),
                "beams that end nearer hit the vehicle itself, and are not written");
  schema.group("image", image);
  schema.group("scan_matching", scan_matching);
  schema.number("publish_rate_hz", publish_rate_hz, Range{0.0, 100.0, true},
                "highest rate, by the wall, of what changed in `map_updates` and `ltr_grids`");
  schema.number("whole_map_period_s", whole_map_period_s, Range::positive(),
                "by the wall, after which the whole `map` is sent again, for those that do not "
                "listen to `map_updates`");
  schema.number("sample_wait_s", sample_wait_s, Range::between(0.0, 60.0),
                "by the wall, that a property sample waits for tf to place its frame");
}

}  // namespace hymm::core
