#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_slam.h"
#include "cekf/local_state_ring.h"
#include "cekf/path_closing.h"
#include "cekf/resumption.h"
#include "cekf/sight.h"

namespace hymm::core {

/// Takes LandmarkSlam back to an earlier scan, lets it wait there, and on again: what CekfSlam says
/// of suspend() and resume(). All events go through process().
class WayBack {
 public:
  /// `slam` outlives the object.
  WayBack(LandmarkSlam& slam, const CekfSlamConfig& config);

  std::optional<ScanOutcome> process(const SensorEvent& event);
  void reset();

  void keepLocalStates(double duration_s);
  std::optional<LocalStateSpan> localStates() const { return ring_.span(); }

  bool suspend(double time_T0_s);
  bool isSuspended() const { return waiting_.has_value(); }
  /// That of the vehicle, while suspended.
  PoseEstimate pose() const;

  Resumption resume(double time_T0_s, const std::vector<PlaceAtScan>& path, bool elsewhere);
  Resumption resumeWithoutClosing(double time_T0_s);

 private:
  /// The vehicle alone, while the filter waits at an earlier scan.
  struct Waiting {
    VehicleState vehicle;
    CompressedEkf filter;
    ScanClock scan_clock;
  };

  std::optional<ScanOutcome> apply(const SensorEvent& event);
  std::optional<ScanOutcome> wait(const SensorEvent& event);
  ScanOutcome waitThrough(Sight sight, LandmarkSlam::Instant start);
  void keepLocalState();

  std::optional<LocalStateRing::Way> findWay(double time_s) const;
  void goAlong(const LocalStateRing::Way& way);
  void replay(const LocalStateRing::Events& events);
  template <typename Go>
  Resumption goBackAndOn(double time_T0_s, Go go);
  Resumption refuse(Resumption::Refusal refusal, const std::string& reason);
  std::string notKept(double time_T0_s) const;

  void beginElsewhere(const Pose2& T_map_base);
  Sight seeAgain(const SensorEvent& event);
  void moveAlong(const SensorEvent& event, Resumption& result);
  Resumption replayAlong(const std::vector<PlaceAtScan>& path,
                         const LocalStateRing::Events& events);
  void closeAt(const Pose2& T_map_base, Sight sight, Resumption& result);

  LandmarkSlam& slam_;
  int least_pairs_;
  PathClosing closing_;
  LocalStateRing ring_;
  std::optional<Waiting> waiting_;  ///< while suspended
  bool replaying_ = false;
};

}  // namespace hymm::core
