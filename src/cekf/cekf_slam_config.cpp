#include "cekf/cekf_slam_config.h"

namespace hymm::core {
namespace {

// A probability that makes a usable chi-square gate.
const Range kGateProbability = Range::between(0.5, 0.99999999);
const Range kProbability = Range::between(0.001, 0.999);

}  // namespace

void ActiveAreaConfig::describe(ConfigSchema& schema) {
  schema.number("cell_m", cell_m, Range{0.0, 10000.0, true},
                "edge of the square cells; leaving one triggers the global update");
  schema.number("hysteresis_m", hysteresis_m, Range::notNegative(),
                "how far beyond the border of its cell the vehicle must be");
  schema.integer("max_origin_states", max_origin_states, Range::between(32, 4000),
                 "states activated since the last global update, or active now, that call for the "
                 "next one; at twice as many a scan waits for one that is still pending");
}

void UpdateConfig::describe(ConfigSchema& schema) {
  schema.text(
      "linearisation", linearisation,
      "where Jacobians are taken: at the latest estimates, or at each landmark's first one, "
      "which keeps directions that nothing observes free of information",
      {"latest", "first_estimates"});
  schema.number("relinearise_m", relinearise_m, Range::notNegative(),
                "a landmark's first estimate is taken anew, and its covariance carried along, when "
                "the estimate has moved by more than this; as a share of the nearest ranges, what "
                "Jacobians are then off by");
  schema.integer("max_iterations", max_iterations, Range::between(1, 20),
                 "of an update whose correction the measurements are not linear over; 1 never "
                 "repeats one, first estimates only those that correct by more than "
                 "large_correction_m");
}

void AssociationConfig::describe(ConfigSchema& schema) {
  schema.text("method", method,
              "how observations without identity are paired: all of a scan jointly, or each with "
              "its nearest landmark",
              {"joint", "nearest"});
  schema.number("individual_probability", individual_probability, kGateProbability,
                "chi-square gate of a single observation. Wide, since an error of the vehicle's "
                "prediction shifts all observations of a scan: whether they fit is for the joint "
                "gate to say");
  schema.number("unpaired_probability", unpaired_probability, kGateProbability,
                "its chi-square quantile is what leaving an observation out costs");
  schema.number("joint_probability", joint_probability, kGateProbability,
                "chi-square gate of all observations of a scan together");
  schema.number("new_landmark_probability", new_landmark_probability, kGateProbability,
                "an observation inside this gate of a landmark starts no new one");
  schema.number("identity_probability", identity_probability, kGateProbability,
                "gate of observations whose identity the sensor reads");
  schema.number("unmapped_density_per_m2", unmapped_density_per_m2, Range::positive(),
                "of objects that look like landmarks and are not in the map; about the density of "
                "landmarks where the map has not been. Where the vehicle is so uncertain that an "
                "observation could be of one of them, it proves nothing alone");
  schema.number(
      "coincidence_probability", coincidence_probability, Range::between(1e-12, 1.0),
      "pairings of observations and landmarks count only where it is less likely than this "
      "that other objects stand there by chance");
  schema.number("rival_probability", rival_probability, Range::between(1e-12, 1.0),
                "and only where it is less likely than this that the observations are of other "
                "landmarks, as of the next tree of a row");
  schema.integer("max_nodes", max_nodes, Range::between(10, 1e8),
                 "of the joint compatibility search; beyond, the best so far is taken");
  schema.flag("use_diameter", use_diameter, "diameters tell landmarks apart");
  schema.number("diameter_irregularity_m", diameter_irregularity_m, Range::notNegative(),
                "deviation of a trunk's diameter between the sides it is seen from");
  schema.flag(
      "use_unidentified", use_unidentified,
      "in sets where some observations carry an identity: associate the others by position");
}

void SlipConfig::describe(ConfigSchema& schema) {
  schema.number(
      "factor", factor, Range::between(1.0, 100.0),
      "by which the motion since the last explained scan may have been worse than it claims, "
      "where that explains what else would be explained by nothing");
  schema.number("probability", probability, Range::between(0.0, 0.5),
                "of that, before any one scan: the odds that the explanation has to be worth; 0: "
                "never");
}

void MotionNoiseConfig::describe(ConfigSchema& schema) {
  schema.number("doubt", doubt, Range::between(0.0, 10.0),
                "share by which the deviations of the motion are larger than the vehicle's noise "
                "claims, one time in six; innovations tell by how much they are; 0: the claims are "
                "believed");
  schema.number("memory_s", memory_s, Range::positive(),
                "over which that may change: with the ground, the load, the tyres");
}

void LandmarkConfig::describe(ConfigSchema& schema) {
  schema.integer("promote_sightings", promote_sightings, Range::between(1, 100),
                 "scans that must see an object before it becomes a landmark");
  schema.number("promote_share", promote_share, Range::between(0.0, 1.0),
                "least share of the scans since the first of them that must see it");
  schema.number("promote_span_s", promote_span_s, Range::notNegative(),
                "least time between the first and the last of them, at one place: by then, what "
                "walks or drives has moved on");
  schema.integer("confirm_observations", confirm_observations, Range::between(0, 1000),
                 "a landmark with fewer is dropped when the vehicle has left it behind");
  schema.number("unconfirmed_life_s", unconfirmed_life_s, Range::notNegative(),
                "time since its last sighting after which it counts as left behind");
  schema.number("min_separation_m", min_separation_m, Range::notNegative(),
                "of a new landmark from all others");
  schema.number("visible_range_m", visible_range_m, Range::positive(),
                "farthest range at which a landmark is expected to be seen again");
  schema.number("field_margin_rad", field_margin_rad, Range::between(0.0, 1.0),
                "from the edges of the scan inside which it is expected");
  schema.number("detection_probability", detection_probability, kProbability,
                "of a landmark that exists and should be visible");
  schema.number("false_detection_probability", false_detection_probability, kProbability,
                "of one that does not exist");
  schema.number("drop_log_odds", drop_log_odds, Range::between(-100.0, 0.0),
                "log-odds of existence below which a landmark is dropped");
  schema.number("pin_delay_s", pin_delay_s, Range::between(0.0, 60.0),
                "by stamps, after which landmarks that span LTRs are no longer dropped; as long as "
                "`ltrs` may take, so that live and offline agree");
  schema.number("merge_distance_m", merge_distance_m, Range::notNegative(),
                "largest distance between two estimates of one object; 0 never merges");
  schema.number("constellation_radius_m", constellation_radius_m, Range::notNegative(),
                "around the vehicle: landmarks in it that were seen lately are compared, all "
                "together, with older ones that they may be; 0 never compares");
  schema.number("constellation_span_s", constellation_span_s, Range::notNegative(),
                "what was seen within this time was seen lately");
  schema.number("constellation_coincidence", constellation_coincidence, Range::between(1e-12, 1.0),
                "they are fused only if it is less likely than this that other objects stand there "
                "by chance; stricter than for a scan, since it cannot be undone");
  schema.number("merge_probability", merge_probability, kGateProbability,
                "chi-square gate of their difference");
}

void PlaceFindingConfig::describe(ConfigSchema& schema) {
  schema.number(
      "linear_heading_rad", linear_heading_rad, Range::positive(),
      "deviation of the heading, relative to the landmarks seen last, beyond which a scan "
      "is not associated one by one: after a gap in the motion, say. It is looked for as a "
      "whole among all landmarks");
  schema.number("coincidence", coincidence, Range::between(1e-12, 1.0),
                "a place is believed only if it is less likely than this that other objects stand "
                "there by chance, and that another place explains the scan");
  schema.number("hold_s", hold_s, Range::notNegative(),
                "for so long nothing is mapped without a place; then a new part of the map begins");
}

void LastingErrorConfig::describe(ConfigSchema& schema) {
  schema.number("range_share", range_share, Range::between(0.0, 0.99),
                "of the variance that an observation claims of its range, which lasts while the "
                "landmark is seen from much the same place; 0: each observation errs anew");
  schema.number("bearing_share", bearing_share, Range::between(0.0, 0.99),
                "the same of its bearing");
  schema.number("view_change", view_change, Range::positive(),
                "change of the way from the landmark to the sensor, as a share of the range, over "
                "which such an error is forgotten to 1/e");
}

void ResumptionConfig::describe(ConfigSchema& schema) {
  schema.number(
      "plain_distance_m", plain_distance_m, Range::positive(),
      "an observation seen from the path is of the one landmark that is nearer than this, "
      "if no other is nearly as near");
  schema.integer("least_pairs", least_pairs, Range::between(2, 100),
                 "observations told that way that it takes to close the loop");
  schema.number("joint_probability", joint_probability, kGateProbability,
                "chi-square gate of all of them together");
  schema.number("most_inflation", most_inflation, Range::between(1.0, 100.0),
                "times that the covariance of the vehicle's pose may be taken until they pass");
}

void GpsConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "fuse gps/fix");
  schema.number("gate_probability", gate_probability, kGateProbability, "chi-square gate of a fix");
  schema.number("min_deviation_m", min_deviation_m, Range::positive(),
                "no fix is trusted more than this, whatever it says");
  schema.number(
      "alignment_baseline_m", alignment_baseline_m, Range::positive(),
      "distance, by the fixes and in the map, before the map is aligned with east and north");
  schema.integer("alignment_fixes", alignment_fixes, Range::between(2, 10000),
                 "number of fixes that agree before that; if so many are refused before one is "
                 "used, the map is aligned anew");
}

void CekfSlamConfig::describe(ConfigSchema& schema) {
  schema.text("motion_input", motion_input,
              "what moves the filter: an Ackermann vehicle's encoders, or odometry",
              {"dead_reckoning", "odom"});
  schema.text("observation_input", observation_input,
              "laser scans, clouds of points of a 3D sensor, or landmarks that the robot detects "
              "itself",
              {"scan", "points", "detections"});
  schema.flag(
      "use_time_increment", use_time_increment,
      "believe a scan that tells how long it takes from beam to beam, and a cloud that tells "
      "when its points were measured, and undo what the vehicle moved meanwhile; else all beams "
      "count as measured at the stamp");
  schema.number("landmark_block_range_m", landmark_block_range_m, Range::between(0.0, 1000.0),
                "cross-covariances are published for pairs of landmarks no farther apart");
  schema.number("landmark_rate_hz", landmark_rate_hz, Range{0.0, 100.0, true},
                "highest rate of the whole landmark map");
  schema.number("large_correction_m", large_correction_m, Range::positive(),
                "a scan that moves an active landmark by more counts as a map correction, carries "
                "it to all landmarks at once, and publishes them");
  schema.number(
      "local_states_s", local_states_s, Range::between(0.0, 600.0),
      "time, by stamps, that the filter can go back by when the relocaliser is asked; longer than "
      "supervisor/switching/longest_doubt_s; 0: none");
  schema.group("merger", merger);
  schema.group("perception", perception);
  schema.group("active_area", active_area);
  schema.group("update", update);
  schema.group("association", association);
  schema.group("slip", slip);
  schema.group("place_finding", place_finding);
  schema.group("motion_noise", motion_noise);
  schema.group("landmarks", landmarks);
  schema.group("lasting_errors", lasting_errors);
  schema.group("resumption", resumption);
  schema.group("gps", gps);
}

}  // namespace hymm::core
