#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "hybrid_map/beam_cutter.h"
#include "hybrid_map/hybrid_map_config.h"
#include "hybrid_map/layer_writer.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// Writes the beams of scans into the occupancy layer (1), exactly: each beam is cut at the sides
/// that it crosses, and each piece passes the cells of its LTR one by one. A cell in which a beam
/// ends is not freed by other beams of the same scan that graze it.
class ScanWriter {
 public:
  /// The partition outlives the object.
  ScanWriter(const OccupancyConfig& config, LtrPartition& partition);

  /// Returns the number of beams written.
  std::size_t write(const LaserScan& scan, const Pose2& T_map_laser, LayerWriter& writer);

 private:
  /// Log-odds that a cell gains (1), within bounds.
  struct Increments {
    float hit, miss, least, most;
    float freed(float log_odds) const { return std::max(log_odds + miss, least); }
    float occupied(float log_odds) const { return std::min(log_odds + hit, most); }
  };
  class TileWindow;
  /// A cell in which a beam ends, and what it held before the scan.
  struct Hit {
    CellPlace place;
    float* cell;
    float before;
  };

  void addHit(const BeamPiece& last, LayerWriter& writer);
  void chainPieces();
  void freeInLtr(int first_piece, LayerWriter& writer);
  void freeOutside(int first_piece, LayerWriter& writer);
  void occupyHits();

  OccupancyConfig config_;
  LtrPartition& partition_;
  BeamCutter cutter_;
  Increments increments_;
  std::vector<BeamPiece> pieces_;  ///< of the scan
  // Chains of the pieces in the same LTR, or outside of all:
  std::vector<int> first_pieces_;  ///< by LTR + 1; kNone between scans
  std::vector<int> next_pieces_;   ///< by piece; kNone for the last of a chain
  std::vector<int> chains_;        ///< LTRs of the scan, each once
  std::vector<Hit> hits_;
};

}  // namespace hymm::core
