#include "hybrid_map/hybrid_map_config.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "hybrid_map/layer_set.h"

namespace hymm::core {

void CompressionConfig::describe(ConfigSchema& schema) {
  schema.text("form", form,
              "of LTRs beyond active_radius_m: lossless, or lossy (occupancy only: occupied, free "
              "or unknown, in a quadtree)",
              {"lossless", "lossy"});
  schema.number("occupied_probability", occupied_probability, Range::between(0.5, 0.99),
                "lossy: above which a cell stays occupied; all others that were seen become free");
}

void HybridMapConfig::describe(ConfigSchema& schema) {
  schema.number("resolution_m", resolution_m, Range{0.005, 10.0, false},
                "largest side of a cell when its LTR is made");
  schema.text("layers", layers,
              "besides the occupancy, as 'NAME MODEL WORD...; ...': 'height gaussian', 'terrain "
              "category grass asphalt', 'traffic rate dry wet' (weathers to tell apart, or none)");
  schema.integer("day_parts", day_parts, Range::between(1.0, 24.0),
                 "equal parts of the day that rate layers tell apart");
  schema.number("max_pose_deviation_m", max_pose_deviation_m, Range::positive(),
                "of the sensor, relative to the landmarks around; less certain scans are not "
                "written");
  schema.number("max_heading_deviation_rad", max_heading_deviation_rad, Range::positive(),
                "of the sensor, relative to the landmarks around");
  schema.number("max_sample_deviation_m", max_sample_deviation_m, Range::positive(),
                "of a property sample's place; less certain samples are refused");
  schema.number("active_radius_m", active_radius_m, Range::positive(),
                "around the vehicle, in which cells are not compressed");
  schema.number(
      "max_memory_mb", max_memory_mb, Range::positive(),
      "for the cells of all LTRs; what lies within active_radius_m must fit, and beyond, "
      "where it does not, LTRs that were not written for longest are emptied and counted");
  schema.group("occupancy", occupancy);
  schema.group("compression", compression);
  schema.group("partition", partition);
  schema.group("waiting", waiting);
  schema.group("traffic", traffic);
}

double HybridMapConfig::activeMemory_mb() const {
  std::vector<std::string> ignored;
  const LayerSet set(layers, day_parts, ignored);
  const double edge = 2.0 * (active_radius_m + partition.max_side_m);
  // A cell is a parallelogram around the angle that is nearest to a right one: of a triangle whose
  // smallest angle is s, at worst pi - 2 s.
  const double sine = std::min(std::sin(M_PI / 3.0), std::sin(2.0 * partition.min_angle_rad));
  const double cells = edge * edge / (resolution_m * resolution_m * sine);
  return cells * set.channelsTogether() * static_cast<double>(sizeof(float)) / 1e6;
}

std::vector<std::string> HybridMapConfig::problems() const {
  HybridMapConfig copy = *this;
  ConfigSchema schema;
  copy.describe(schema);
  std::vector<std::string> problems = rangeProblems(schema);
  const LayerSet set(layers, day_parts, problems);
  TrafficCounter(traffic, set, resolution_m, problems);
  if (partition.min_side_m > partition.max_side_m) {
    problems.emplace_back("partition.min_side_m: is greater than partition.max_side_m.");
  }
  if (compression.isLossy() && compression.occupied_probability >= occupancy.max_probability) {
    problems.emplace_back(
        "compression.occupied_probability: is not below occupancy.max_probability, so that no "
        "cell would stay occupied.");
  }
  if (!problems.empty()) return problems;
  if (const double needed = activeMemory_mb(); needed > max_memory_mb) {
    std::ostringstream text;
    text << "resolution_m: cells of " << resolution_m << " m in " << set.count()
         << " layer(s) need " << std::ceil(needed) << " MB within active_radius_m, more than "
         << "max_memory_mb = " << max_memory_mb << "; choose a coarser resolution, fewer layers, "
         << "or more memory.";
    problems.push_back(text.str());
  }
  const double scan_mb = WaitingConfig::scanMemory_mb(occupancy.range_m, resolution_m);
  if (scan_mb > waiting.max_memory_mb) {
    std::ostringstream text;
    text << "occupancy.range_m: one scan up to " << occupancy.range_m << " m needs "
         << std::ceil(scan_mb) << " MB with cells of " << resolution_m
         << " m where there is no LTR, more than waiting.max_memory_mb = " << waiting.max_memory_mb
         << "; choose a shorter range, a coarser resolution, or more memory.";
    problems.push_back(text.str());
  }
  return problems;
}

}  // namespace hymm::core
