#include "hybrid_map/occupancy_config.h"

namespace hymm::core {

void OccupancyConfig::describe(ConfigSchema& schema) {
  schema.number("hit_probability", hit_probability, Range::between(0.5, 0.99),
                "that a cell is occupied in which one beam ends");
  schema.number("miss_probability", miss_probability, Range::between(0.01, 0.5),
                "that a cell is occupied through which one beam passes");
  schema.number("min_probability", min_probability, Range::between(0.001, 0.5),
                "below which no more is learned, so that what changes can be relearned");
  schema.number("max_probability", max_probability, Range::between(0.5, 0.999),
                "above which no more is learned");
  schema.number("range_m", range_m, Range::positive(), "up to which beams are written");
  schema.number("clear_range_m", clear_range_m, Range::notNegative(),
                "up to which a beam without return shows free space: half the range at which the "
                "laser sees a dark target (10 % reflectivity); 0 if such beams show nothing");
}

}  // namespace hymm::core
