#pragma once

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include <hymm/GridStatus.h>
#include <hymm/LtrMap.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "hybrid_map/occupancy_image.h"
#include "pipeline/grid_files.h"
#include "pipeline/results_writer.h"
#include "ros/cause_log.h"

namespace hymm {

/// Keeps what the node `hymm_grid` tells, and writes it as an offline run does: ltrs.csv,
/// map_memory.csv, map.pgm and map.yaml. Where that node does not run, nothing is written. A map
/// that cannot be used is refused, and counted with its cause.
class GridRecord {
 public:
  /// `folder`: of the results; it exists. `causes` outlives the object.
  GridRecord(std::filesystem::path folder, CauseLog& causes)
      : folder_(std::move(folder)), causes_(causes) {}

  void subscribe(ros::NodeHandle& handle);

  void takeLtrs(const LtrMap& message) { ltrs_ = message; }
  void takeMap(const nav_msgs::OccupancyGrid& message);
  /// One that comes before its map does not fit, and is passed over: the map that follows holds it.
  void takeMapUpdate(const map_msgs::OccupancyGridUpdate& message);
  void takeStatus(const GridStatus& message);

  /// Adds the number of LTRs and the CPU time.
  void addTo(core::RunTotals& totals) const;
  /// Throws OutputError.
  void write() const;

 private:
  std::filesystem::path folder_;
  CauseLog& causes_;
  std::optional<LtrMap> ltrs_;
  std::optional<core::OccupancyImage> image_;
  std::optional<GridStatus> status_;
  core::MapMemoryLog memory_log_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace hymm
