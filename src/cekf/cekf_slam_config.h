#pragma once

#include <string>

#include "common/config.h"
#include "perception/perception_config.h"
#include "pipeline/sensor_merger.h"

namespace hymm::core {

/// Which part of the map stays active between global updates.
struct ActiveAreaConfig {
  double cell_m = 30.0;       ///< edge of the square cells
  double hysteresis_m = 3.0;  ///< beyond the cell's border before the area moves on
  int max_origin_states =
      360;  ///< states activated since a global update, or active, that force the next

  void describe(ConfigSchema& schema);
};

/// How a scan corrects the state.
struct UpdateConfig {
  std::string linearisation = "first_estimates";  ///< or "latest"
  double relinearise_m = 0.1;                     ///< move that ends a first estimate's use
  int max_iterations = 3;                         ///< of one update

  bool atFirstEstimates() const { return linearisation == "first_estimates"; }
  void describe(ConfigSchema& schema);
};

/// Which observation belongs to which landmark.
struct AssociationConfig {
  std::string method = "joint";              ///< or "nearest"
  double individual_probability = 0.9999;    ///< chi-square gate of one observation
  double unpaired_probability = 0.9999;      ///< of the quantile that leaving one out costs
  double joint_probability = 0.9999;         ///< chi-square gate of a whole scan
  double unmapped_density_per_m2 = 0.01;     ///< of objects that are not in the map
  double coincidence_probability = 0.05;     ///< below which pairings count as proven
  double rival_probability = 0.001;          ///< below which other pairings of a scan are no rivals
  double new_landmark_probability = 0.9999;  ///< an observation inside this gate is no new landmark
  double identity_probability = 0.999999;    ///< gate of observations with a known identity
  int max_nodes = 20000;
  bool use_diameter = true;
  double diameter_irregularity_m = 0.1;  ///< how much a trunk's diameter differs by side
  bool use_unidentified = true;          ///< observations without identity, where others have one

  void describe(ConfigSchema& schema);
};

/// Motion that is worse than its noise claims: wheels that slip, a tail of an error's distribution.
struct SlipConfig {
  double factor = 3.0;         ///< on the deviations of the motion since the last explained scan
  double probability = 0.001;  ///< of a scan before which it happens; 0: never

  void describe(ConfigSchema& schema);
};

/// What is done where the heading is too uncertain for a filter, after a gap in a recording, say.
struct PlaceFindingConfig {
  double linear_heading_rad = 0.3;  ///< deviation, relative to the landmarks seen last
  double coincidence = 0.001;       ///< below which a place counts as proven
  double hold_s = 120.0;  ///< before what is seen becomes a new part of the map, without a place

  void describe(ConfigSchema& schema);
};

/// How far the vehicle's configuration is believed about the noise of its motion.
struct MotionNoiseConfig {
  double doubt = 0.4;  ///< by which deviations are more than claimed, one time in six; 0: never
  double memory_s = 120.0;  ///< over which that may change, with the ground or a load

  void describe(ConfigSchema& schema);
};

/// How landmarks come and go.
struct LandmarkConfig {
  int promote_sightings = 3;
  double promote_share = 0.3;        ///< of the scans since the first of them
  double promote_span_s = 1.0;       ///< what moves has moved by then
  int confirm_observations = 5;      ///< below, a landmark is dropped once out of sight
  double unconfirmed_life_s = 10.0;  ///< after its last sighting
  double min_separation_m = 0.5;     ///< of a new landmark from all others
  double visible_range_m = 25.0;     ///< farthest range at which a landmark is expected to be seen
  double field_margin_rad = 0.1;     ///< inside the scan's edges
  double detection_probability = 0.7;         ///< of a visible landmark that exists
  double false_detection_probability = 0.05;  ///< of one that does not
  double drop_log_odds = -4.0;                ///< of existence
  double pin_delay_s = 2.0;                   ///< from the stamp of a set of pinned landmarks
  double merge_distance_m = 0.6;              ///< between two estimates of one object
  double constellation_coincidence = 0.001;   ///< below which duplicates count as proven
  double constellation_radius_m = 50.0;  ///< around the vehicle, in which duplicates are looked for
  double constellation_span_s = 30.0;    ///< since the last sighting of a possible duplicate
  double merge_probability = 0.95;

  void describe(ConfigSchema& schema);
};

/// Errors of sightings that last while a landmark is seen from much the same place.
struct LastingErrorConfig {
  double range_share = 0.0;  ///< of the variance that an observation claims
  double bearing_share = 0.0;
  double view_change = 0.1;  ///< over which they are forgotten, as a share of the range

  void describe(ConfigSchema& schema);
};

/// Absolute fixes; off unless asked for.
struct GpsConfig {
  bool enabled = false;
  double gate_probability = 0.99;
  double min_deviation_m = 0.5;        ///< no fix is trusted more than this
  double alignment_baseline_m = 30.0;  ///< travelled before the map is aligned with east and north
  int alignment_fixes = 10;

  void describe(ConfigSchema& schema);
};

/// How a loop is closed along the path that a search has found.
struct ResumptionConfig {
  double plain_distance_m = 1.0;     ///< between an observation, seen from the path, and a landmark
  int least_pairs = 3;               ///< of a scan that closes the loop
  double joint_probability = 0.999;  ///< chi-square gate of all of them together
  double most_inflation = 9.0;       ///< of the covariance of the vehicle's pose

  void describe(ConfigSchema& schema);
};

/// Parameters of the node `cekf_slam`, as config/cekf_slam.yaml documents them.
struct CekfSlamConfig {
  std::string motion_input = "dead_reckoning";
  std::string observation_input = "scan";
  bool use_time_increment = true;  ///< of scans whose beams are measured one after another
  double landmark_block_range_m = 30.0;
  double landmark_rate_hz = 1.0;
  double large_correction_m = 0.5;
  double local_states_s = 20.0;  ///< that can be gone back by when the place was lost
  SensorMergerConfig merger;
  PerceptionConfig perception;
  ActiveAreaConfig active_area;
  UpdateConfig update;
  AssociationConfig association;
  SlipConfig slip;
  PlaceFindingConfig place_finding;
  MotionNoiseConfig motion_noise;
  LandmarkConfig landmarks;
  LastingErrorConfig lasting_errors;
  ResumptionConfig resumption;
  GpsConfig gps;

  void describe(ConfigSchema& schema);
};

}  // namespace hymm::core
