#pragma once

#include "common/config.h"
#include "relocaliser/convergence.h"
#include "relocaliser/density_map.h"
#include "relocaliser/local_map.h"
#include "relocaliser/neighbourhoods.h"
#include "relocaliser/particle_filter.h"

namespace hymm::core {

/// Parameters of the relocaliser, as config/relocaliser.yaml documents them.
struct RelocaliserConfig {
  int seed = 0;  ///< of all randomness
  int initial_particles = 50000;
  int global_particles = 50000;  ///< in each local map, where the vehicle may be anywhere
  int initial_observations = 3;  ///< a scan with fewer does not begin
  /// Times the covariance of the prior: a filter that has to be relocalised was surer than it
  /// should.
  double prior_inflation = 4.0;
  double range_m = 30.0;           ///< farthest at which landmarks are observed
  double expected_range_m = 20.0;  ///< within which they should be
  double field_of_view_rad = kPi;
  double recent_s = 2.0;          ///< by whose scans the outcome is compared with all other places
  int rival_bounds = 50000000;    ///< on groups of points, for the search for such places
  double rival_distance_m = 1.5;  ///< beyond it a pose is another place
  double rival_angle_rad = 0.2;
  double history_s = 180.0;  ///< how long what the sensors said is kept
  double replay_s = 10.0;    ///< of it, what a search begins with
  LocalMapConfig local_map;
  NeighbourhoodConfig neighbourhoods;
  DensityConfig density;
  ParticleFilterConfig particles;
  ConvergenceConfig convergence;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
