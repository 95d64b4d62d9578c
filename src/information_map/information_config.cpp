#include "information_map/information_config.h"

namespace hymm::core {

void ExpectedSensor::describe(ConfigSchema& schema) {
  schema.number(
      "range_m", range_m, Range::positive(),
      "up to which landmarks are counted on. Two landmarks in view are up to twice as far "
      "apart: where cekf_slam's landmark_block_range_m is less, of those whose "
      "covariance is not told only the nearer ones count");
  schema.number("min_range_m", min_range_m, Range::positive(), "nearest landmark that is measured");
  schema.number(
      "field_of_view_rad", field_of_view_rad, Range{0.0, 6.2832, true},
      "of the sensor, centred on its x axis; of no effect on omnidirectional; from 6.28 on, "
      "the sensor looks all around");
  schema.number("range_deviation_m", range_deviation_m, Range::positive(),
                "of a measured landmark's range");
  schema.number("bearing_deviation_rad", bearing_deviation_rad, Range{0.0, 1.0, true},
                "of a measured landmark's bearing");
  schema.number("region_sigmas", region_sigmas, Range{0.0, 10.0, false},
                "size of a landmark's region: it counts as visible where all of its region is in "
                "the sensor's range and field of view");
}

void InformationConfig::describe(ConfigSchema& schema) {
  schema.group("sensor", sensor);
  schema.text("heading", heading,
              "for which heading of the sensor a place is judged: as if it looked all around, the "
              "least or the most informative heading, or fixed_heading_rad",
              {"omnidirectional", "worst", "best", "fixed"});
  schema.number("fixed_heading_rad", fixed_heading_rad, Range::between(-kPi, kPi),
                "of the sensor in map, for heading: fixed");
  schema.text("measure", measure,
              "of the 3x3 information on the pose, its heading scaled by length_m: cube root of "
              "the determinant, smallest eigenvalue, or trace, each per m^2",
              {"determinant", "smallest_eigenvalue", "trace"});
  schema.number("length_m", length_m, Range::positive(),
                "at which a deviation of 1 rad counts as much as one of length_m metres");
}

}  // namespace hymm::core
