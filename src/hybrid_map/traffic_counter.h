#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/config.h"
#include "common/pose2.h"
#include "hybrid_map/layer_set.h"
#include "hybrid_map/occupancy_config.h"
#include "perception/laser_scan.h"

namespace hymm::core {

struct TrafficConfig {
  std::string layer;
  std::string weather;
  double free_probability = 0.1;
  double min_width_m = 0.25;
  double square_m = 1.0;
  double period_s = 1.0;

  void describe(ConfigSchema& schema);
};

/// Finds moving objects that the occupancy itself reveals, and counts them for a rate layer: beams
/// side by side, over at least `min_width_m`, that end where the map was certain that nothing
/// stands, all being free two cells around. Some of them must meet a face that looks their way: a
/// wall along which the laser looks sends back nothing before it is near. What was free until a
/// moment ago counts as free: objects that move occupy cells on their way. A moment is what an
/// object that moves takes to leave the cells that are looked at; what is still met there
/// then has come to stay. Places are squares of `square_m`; what is there counts once a period, as
/// does the time for which a square was watched.
class TrafficCounter {
 public:
  /// A sentence in `problems` if the layer is not there, or takes no such samples.
  TrafficCounter(const TrafficConfig& config, const LayerSet& layers, double resolution_m,
                 std::vector<std::string>& problems);

  bool isOn() const { return layer_ >= 0; }
  int layer() const { return layer_; }

  /// Log-odds of a place, 0 where unknown.
  using Occupancy = std::function<float(const Eigen::Vector2d&)>;
  /// Takes a sample for the square around a place.
  using Taker = std::function<void(const Eigen::Vector2d& centre, const LayerSample&)>;

  /// Looks at a scan before it is written. At the end of a period, hands out what was counted.
  /// Returns the number of squares in which something moved, if it is the end of one.
  std::size_t look(const LaserScan& scan, const Pose2& T_map_laser, const OccupancyConfig& written,
                   const Occupancy& occupancy, const Taker& take);

  double square_m() const { return config_.square_m; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(squares_, period_start_s_);
  }

 private:
  using Square = std::pair<int, int>;
  using Cell = std::pair<int, int>;
  /// Ends of beams side by side that met something that moves.
  struct Run {
    std::vector<Eigen::Vector2d> ends;
    double last_range_m = 0.0;
    bool has_steep_face = false;
  };

  static void extend(Run& run, const Eigen::Vector2d& end, double range_m, double spacing_rad);
  void finish(Run& run, double time_s);
  Square squareOf(const Eigen::Vector2d& place) const;
  Cell cellOf(const Eigen::Vector2d& place) const;
  double timeToLeave_s(int cells) const;
  bool isCertainlyFree(const Eigen::Vector2d& place, double time_s,
                       const Occupancy& occupancy) const;
  bool wasFreeAt(const Eigen::Vector2d& place, double time_s) const;
  void forgetEntered(double time_s);
  void watch(const LaserScan& scan, const Pose2& T_map_laser, const OccupancyConfig& written);
  std::size_t handOut(double time_s, const Taker& take);

  TrafficConfig config_;
  double cell_m_;
  int layer_ = -1;
  float free_log_odds_;
  std::map<Square, bool> squares_;  ///< watched in this period; whether something moved there
  std::optional<double> period_start_s_;
  std::map<Cell, double> entered_;  ///< free cells in which something was met: since when [s]
};

}  // namespace hymm::core
