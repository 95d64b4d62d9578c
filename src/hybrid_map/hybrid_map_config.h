#pragma once

#include <string>
#include <vector>

#include "common/config.h"
#include "hybrid_map/occupancy_config.h"
#include "hybrid_map/partition_config.h"
#include "hybrid_map/traffic_counter.h"
#include "hybrid_map/waiting_tiles.h"

namespace hymm::core {

/// How LTRs far from the vehicle are compressed.
struct CompressionConfig {
  std::string form = "lossless";
  double occupied_probability = 0.65;

  bool isLossy() const { return form == "lossy"; }
  void describe(ConfigSchema& schema);
};

/// Parameters of the hybrid metric map, as the node `hymm_grid` documents them.
struct HybridMapConfig {
  double resolution_m = 0.2;
  std::string layers;
  int day_parts = 4;
  double max_pose_deviation_m = 0.2;
  double max_heading_deviation_rad = 0.02;
  double max_sample_deviation_m = 1.0;
  double active_radius_m = 50.0;
  double max_memory_mb = 500.0;
  OccupancyConfig occupancy;
  CompressionConfig compression;
  PartitionConfig partition;
  WaitingConfig waiting;
  TrafficConfig traffic;

  void describe(ConfigSchema& schema);

  /// Everything that makes the configuration unusable, one sentence each.
  std::vector<std::string> problems() const;

  /// Memory [MB] that cells take if the neighbourhood of the vehicle is covered by LTRs with all
  /// layers written.
  double activeMemory_mb() const;
};

}  // namespace hymm::core
