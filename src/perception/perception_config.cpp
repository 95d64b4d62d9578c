#include "perception/perception_config.h"

namespace hymm::core {

void LaserNoise::describe(ConfigSchema& schema) {
  schema.number("range_noise_m", range_noise_m, Range::positive(),
                "deviation of a single range, independent from beam to beam");
  schema.number("range_offset_deviation_m", range_offset_deviation_m, Range::notNegative(),
                "deviation of the error that all ranges on one object share (calibration, "
                "reflectivity, tilt)");
  schema.number("bearing_offset_deviation_rad", bearing_offset_deviation_rad,
                Range::between(0.0, 0.1),
                "deviation of the error that all bearings on one object share (alignment, motion "
                "during the sweep)");
  schema.number("beam_width_rad", beam_width_rad, Range::between(0.0, 0.05),
                "angle by which an object looks wider than it is, because a beam that only "
                "touches it returns from it");
}

void TrunkConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "whether trunks are looked for");
  schema.number("max_range_m", max_range_m, Range::positive(), "of a trunk's centre");
  schema.number("min_diameter_m", min_diameter_m, Range::notNegative(),
                "of a trunk; a shape that is thinner by two deviations is not one");
  schema.number("max_diameter_m", max_diameter_m, Range{0.0, 10.0, true}, "of a trunk");
  schema.integer("min_beams", min_beams, Range::between(1.0, 100.0), "that hit a trunk");
  schema.integer("max_missed_beams", max_missed_beams, Range::between(0.0, 10.0),
                 "without a measurement in a row that do not end a shape");
  schema.number("max_incidence_rad", max_incidence_rad, Range::between(0.5, 1.55),
                "between a beam and a surface's normal, up to which the surface returns a beam; "
                "background that such a surface could join to the shape makes it no trunk");
  schema.number("surface_deviation", surface_deviation, Range::between(0.0, 1.0),
                "of single points of a trunk from the best circle, as a share of its radius");
  schema.number("outline_deviation", outline_deviation, Range::between(0.0, 1.0),
                "of a trunk's diameter from one view to another, as a share of its diameter");
  schema.number("shape_confidence", shape_confidence, Range::between(0.5, 0.999999),
                "share of trunks that the test for a round shape lets pass");
}

void ReflectorConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "whether reflectors are looked for");
  schema.number("max_range_m", max_range_m, Range::positive(), "of a reflector's centre");
  schema.number("min_intensity", min_intensity, Range::any(),
                "of a beam from a reflector, in the device's unit");
  schema.number("diameter_m", diameter_m, Range::notNegative(), "of the reflecting poles");
  schema.number("max_width_m", max_width_m, Range::positive(),
                "of neighbouring bright beams together; wider ones are no pole");
  schema.integer("min_beams", min_beams, Range::between(1.0, 100.0), "that are bright");
}

void PerceptionConfig::describe(ConfigSchema& schema) {
  schema.group("laser", laser);
  schema.group("trunks", trunks);
  schema.group("reflectors", reflectors);
}

}  // namespace hymm::core
