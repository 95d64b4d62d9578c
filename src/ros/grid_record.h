#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <hymm/GridStatus.h>
#include <hymm/LtrMap.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>

#include "hybrid_map/occupancy_image.h"
#include "pipeline/grid_files.h"
#include "pipeline/results_writer.h"

namespace hymm {

/// Keeps what the node `hymm_grid` tells, and writes it as an offline run does: ltrs.csv,
/// map_memory.csv, map.pgm and map.yaml. Where that node does not run, nothing is written.
class GridRecord {
 public:
  /// `folder`: of the results; it exists.
  explicit GridRecord(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void subscribe(ros::NodeHandle& handle);

  /// Adds the number of LTRs and the CPU time.
  void addTo(core::RunTotals& totals) const;
  /// Throws OutputError.
  void write() const;

 private:
  void takeLtrs(const LtrMap& message) { ltrs_ = message; }
  void takeMap(const nav_msgs::OccupancyGrid& message);
  void takeMapUpdate(const map_msgs::OccupancyGridUpdate& message);
  void takeStatus(const GridStatus& message);

  std::filesystem::path folder_;
  std::optional<LtrMap> ltrs_;
  std::optional<core::OccupancyImage> image_;
  std::optional<GridStatus> status_;
  core::MapMemoryLog memory_log_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace hymm
