#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "evaluation/fix_gate.h"
#include "evaluation/rigid_alignment.h"
#include "evaluation/trajectory.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// How far GPS fixes lie from the antenna's estimated place after one rigid alignment of each map
/// frame, computed while a run goes on. Same measure as computeGpsErrors() over the whole run.
class GpsAlignment {
 public:
  /// Poses in order of time.
  void addPose(const StampedPose& T_map_base);

  /// Fixes in order of time; each is compared once a pose at or past its stamp has come.
  void addFix(const GpsFix& fix);

  /// Poses and fixes from here on belong to another map frame.
  void startMap();

  /// Fixes compared so far.
  std::size_t count() const;

  /// Root of the mean squared distance [m]; nothing with fewer than three fixes in every map.
  std::optional<double> rmse() const;

 private:
  struct Sum {
    double squared_error_m2 = 0.0;
    std::size_t count = 0;
  };
  Sum withCurrentMap() const;

  std::optional<StampedPose> last_pose_;
  std::deque<GpsFix> waiting_;
  FixGate gate_;
  RigidAlignment alignment_;
  Sum finished_maps_;
};

}  // namespace hymm::core
