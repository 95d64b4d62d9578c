#pragma once

#include <algorithm>
#include <cstddef>

#include "hybrid_map/beam_cutter.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/layer_writer.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// Writes the beams of scans into the occupancy layer (1), exactly: each beam is cut at the sides
/// that it crosses, and each piece passes the cells of its LTR one by one.
class ScanWriter {
 public:
  /// The partition outlives the object.
  ScanWriter(const OccupancyConfig& config, LtrPartition& partition);

  /// Returns the number of beams written.
  std::size_t write(const LaserScan& scan, const Pose2& T_map_laser, LayerWriter& writer);

 private:
  void writeBeam(const Eigen::Vector2d& start, const Eigen::Vector2d& end, bool hits,
                 LayerWriter& writer);
  void writePiece(const BeamPiece& piece, const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                  bool hits, LayerWriter& writer);
  /// Log-odds that a cell gains (1), within bounds.
  struct Increments {
    float hit, miss, least, most;
    void free(float& log_odds) const { log_odds = std::max(log_odds + miss, least); }
    void occupy(float& log_odds) const { log_odds = std::min(log_odds + hit, most); }
  };

  OccupancyConfig config_;
  LtrPartition& partition_;
  BeamCutter cutter_;
  Increments increments_;
};

}  // namespace hymm::core
