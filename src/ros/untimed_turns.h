#pragma once

#include <map>
#include <optional>
#include <string>

#include "perception/laser_scan.h"
#include "ros/cause_log.h"
#include "vehicle/motion_input.h"

namespace hymm {

/// Watches what it costs that a turning laser does not tell when its beams were measured: how far
/// the vehicle moves in one turn, by which the scan is bent. Says so once it is more than kTold_m.
class UntimedTurns {
 public:
  static constexpr double kTold_m = 0.2;

  void take(const core::MotionInput& input);

  /// A scan all of whose beams count as measured at its stamp. `period_s`: from scan to scan, where
  /// that is told; else it is taken from the stamps.
  void take(const core::LaserScan& scan, std::optional<double> period_s, const std::string& frame,
            CauseLog& causes);

  /// The worst of all, as a sentence; empty where it is not worth one.
  std::string summary() const;

  /// Another recording begins.
  void reset();

 private:
  struct Clock {
    double last_s = 0.0;
    double difference_s = 0.0;  ///< of the last two; 0 before
  };

  double periodByStamps(double time_s, const std::string& frame);

  double speed_mps_ = 0.0;
  std::map<std::string, Clock> clocks_;  ///< by frame
  double farthest_m_ = 0.0;
  std::string farthest_frame_;
};

/// Whether a scan shows something, be it free space, in each eighth of a turn.
bool showsFullTurn(const core::LaserScan& scan);

}  // namespace hymm
