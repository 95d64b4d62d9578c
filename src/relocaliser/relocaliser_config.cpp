#include "relocaliser/relocaliser_config.h"

namespace hymm::core {

void RelocaliserConfig::describe(ConfigSchema& schema) {
  schema.integer("seed", seed, Range::between(0, 2147483647), "of all randomness");
  schema.integer("initial_particles", initial_particles, Range::between(1000, 5000000),
                 "particles at the start");
  schema.integer("global_particles", global_particles, Range::between(1000, 5000000),
                 "the same in each local map, where the vehicle may be anywhere");
  schema.integer("initial_observations", initial_observations, Range::between(2, 100),
                 "fewest observations of the scan that begins");
  schema.number("prior_inflation", prior_inflation, Range::between(1.0, 100.0),
                "times the covariance of the prior: the filter was surer than it should have been");
  schema.number("range_m", range_m, Range{1.0, 1000.0},
                "farthest range at which landmarks are observed");
  schema.number("expected_range_m", expected_range_m, Range{1.0, 1000.0},
                "range within which a landmark that is not hidden should be observed");
  schema.number("field_of_view_rad", field_of_view_rad, Range{0.1, 6.2832},
                "of the sensor, symmetric about its x axis");
  schema.number("recent_s", recent_s, Range::between(0.1, 60.0),
                "time by whose scans, ten at most, the outcome is compared with all other places");
  schema.integer(
      "rival_bounds", rival_bounds, Range::between(1000, 2000000000),
      "bounds on points or groups of points that the search for such places may compute; if "
      "it has not excluded all by then, the outcome is not believed");
  schema.number("rival_distance_m", rival_distance_m, Range{0.1, 100.0},
                "a pose farther from the outcome than this is another place ...");
  schema.number("rival_angle_rad", rival_angle_rad, Range{0.01, 3.2},
                "... or one that is turned by more than this");
  schema.number(
      "history_s", history_s, Range::between(10.0, 3600.0),
      "how long motion and observations are kept; a scan in good order that is longer ago "
      "cannot be begun from");
  schema.number(
      "replay_s", replay_s, Range::between(0.0, 3600.0),
      "of what was kept, what a search begins with; before it, the motion moves the prior");
  schema.group("local_map", local_map);
  schema.group("neighbourhoods", neighbourhoods);
  schema.group("density", density);
  schema.group("particles", particles);
  schema.group("convergence", convergence);
}

}  // namespace hymm::core
