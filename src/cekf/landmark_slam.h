#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cekf/active_area.h"
#include "cekf/cekf_slam.h"
#include "cekf/compressed_ekf.h"
#include "cekf/gps_datum.h"
#include "cekf/landmark_life_cycle.h"
#include "cekf/landmark_pins.h"
#include "cekf/local_state_ring.h"
#include "cekf/place_finder.h"
#include "cekf/scan_associator.h"
#include "cekf/scan_clock.h"
#include "cekf/scan_update.h"
#include "cekf/sight.h"
#include "cekf/vehicle_state.h"
#include "perception/perception.h"

namespace hymm::core {

/// The filter, its landmarks and the vehicle, driven forwards by events: all of CekfSlam but the
/// way back, whose functions mean the same where they have the same name.
class LandmarkSlam {
 public:
  using Counts = CekfSlam::Counts;
  using CpuTimes = CekfSlam::CpuTimes;
  using Instant = std::chrono::steady_clock::time_point;

  LandmarkSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle,
               CekfSlam::GlobalUpdates global_updates);

  /// An event other than a ClockReset.
  std::optional<ScanOutcome> process(const SensorEvent& event);
  void reset();

  PoseEstimate pose() const;
  Calibration calibration() const;
  Eigen::Matrix3d calibrationCovariance() const;
  LaserCalibration laserCalibration() const;
  Eigen::Vector2d motionNoiseFactors() const { return estimate_.vehicle.noiseScale().factors(); }
  std::uint64_t version() const { return version_; }
  void setVersion(std::uint64_t version) { version_ = version; }
  std::size_t landmarkCount() const { return life_cycle_.registry().size(); }
  bool hasLandmark(int id) const { return life_cycle_.registry().contains(id); }
  double lastScan_s() const { return scan_clock_.last_s(); }
  const ScanClock& scanClock() const { return scan_clock_; }

  void requestMap(double block_range_m, std::function<void(LandmarkMap)> take);
  bool requestJointLandmarks(const std::vector<int>& ids, std::function<void(JointLandmarks)> take);
  bool requestVehicleAmongLandmarks(const std::vector<int>& ids,
                                    std::function<void(VehicleAmongLandmarks)> take);
  LandmarkUpdate takeUpdate();
  void pinLandmarks(double time_s, const std::vector<int>& ids) { pins_.tell(time_s, ids); }

  std::string saveState();
  void loadState(std::string_view bytes, const std::string& name, MapUse use);
  void checkState(std::string_view bytes, const std::string& name) const;
  void placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance);

  Counts counts() const;
  CpuTimes cpuTimes() const;
  /// Those that events are counted in, for what takes the place of an event, or goes over one
  /// again.
  Counts& eventCounts() { return counts_; }
  double& filterCpu_s() { return cpu_times_.filter_s; }

  // --- What process() is made of, for the way back -------------------------------------------

  Sight see(const SensorEvent& event);
  ScanOutcome refuse(const Sight& sight);
  /// Takes observations that cannot be used out of the set, and counts them.
  void refuseUnusable(Sight& sight);
  void takeMotion(const MotionInput& input);
  /// Takes the vehicle to where it should be at the time of the set, and the set to that time.
  void begin(Sight& sight);
  /// Finds the landmarks of a set. Where the motion as it claims to be leaves most of the
  /// observations without one, and a motion much worse than that would not, it was worse: the
  /// vehicle's covariance grows by it.
  ScanAssociation associate(const ObservationSet& set);
  /// What follows from a set once the filter has learnt from it. `updated` false: the update was
  /// refused.
  void finish(Sight sight, const ScanAssociation& association, bool updated, Instant start,
              ScanOutcome& outcome);

  CompressedEkf& filter() { return estimate_.filter; }
  const CompressedEkf& filter() const { return estimate_.filter; }
  VehicleState& vehicle() { return estimate_.vehicle; }
  LandmarkLifeCycle& lifeCycle() { return life_cycle_; }

  /// Whether global updates wait until they are released. reset() does not change it.
  void holdGlobalUpdates(bool hold);
  LocalStateRing::Memory remembered() const;
  /// All but the landmarks' register.
  void recall(const FilterMemory& memory);

 private:
  /// What begins anew with each recording.
  struct Estimate {
    VehicleState vehicle;
    CompressedEkf filter;
    std::optional<GpsDatum> gps;
  };

  Estimate newEstimate() const;
  void processGps(const GpsFix& fix);
  void beginWithMotion(double time_s);
  void refuseWithoutMotion(Sight& sight);
  ScanOutcome processSet(Sight sight, Instant start);
  std::optional<ScanAssociation> associateAnywhere(const ObservationSet& set);
  bool update(const ObservationSet& set, ScanAssociation& association, ScanOutcome& outcome);
  void extendMap(const ObservationSet& set, const LaserScan* scan, const SensorPlacement& sensor,
                 const ScanAssociation& association, ScanOutcome& outcome);
  void countObservations(const ScanAssociation& association, const std::vector<int>& created,
                         int missed, ScanOutcome& outcome);
  int countConfirmed(const ScanAssociation& association) const;
  SensorPlacement sensorPlacement(const ObservationSet& set) const;
  Eigen::Matrix3d covarianceAmongSeen(const ScanAssociation& association) const;
  void spreadCorrection();
  void refreshIfSettled();
  void keepActiveArea();

  template <class Archive>
  void describeState(Archive& archive);
  void restoreState(std::string_view bytes, const std::string& name);
  bool isThere(const DiameterState& diameter) const;
  void goOnAfterLoad(double time_s);

  CekfSlamConfig config_;
  VehicleConfig vehicle_config_;
  CekfSlam::GlobalUpdates global_updates_;
  Perception perception_;
  ScanAssociator associator_;
  ScanUpdate scan_update_;
  PlaceFinder place_finder_;
  LandmarkLifeCycle life_cycle_;
  LandmarkPins pins_;
  ActiveArea area_;
  bool holds_global_updates_ = false;
  Estimate estimate_;
  std::size_t settled_updates_ = 0;  ///< global updates whose places life_cycle_ knows
  std::uint64_t version_ = 0;
  std::uint64_t told_version_ = 0;  ///< up to which takeUpdate() has told
  ScanClock scan_clock_;
  MapUse use_ = MapUse::kExtend;
  bool is_just_loaded_ = false;
  std::size_t past_gaps_ = 0;
  double past_worker_s_ = 0.0;
  double inline_worker_s_ = 0.0;  ///< of global updates, within filter_s
  Counts counts_;
  CpuTimes cpu_times_;
};

/// The deviations of `outcome`'s pose, and the wall time since `start`.
void describeHealth(double time_s, LandmarkSlam::Instant start, ScanOutcome& outcome);

/// Where a set's sensor stood, and what its ranges are off.
void tellSensor(const SensorPlacement& sensor, PoseEstimate& pose);

}  // namespace hymm::core
