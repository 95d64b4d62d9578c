#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/landmark_map.h"
#include "cekf/resumption.h"
#include "cekf/scan_outcome.h"
#include "cekf/vehicle_among_landmarks.h"
#include "cekf/vehicle_state.h"
#include "common/pose2.h"
#include "common/serial_worker.h"
#include "pipeline/sensor_event.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// What becomes of a map that was loaded.
enum class MapUse {
  kExtend,   ///< mapping goes on
  kLocalise  ///< landmarks stay as they are, and none is added; only the vehicle is estimated
};

/// Landmark SLAM with a compressed EKF: the engine of the node `cekf_slam`. Events come in time
/// order (see SensorMerger). Deterministic: same events, same results. Not thread-safe.
class CekfSlam {
 public:
  /// Counts since construction; reset() does not clear them.
  struct Counts {
    std::size_t scans = 0;  ///< accepted scans and observation sets
    std::size_t refused_scans = 0;
    std::size_t refused_motion = 0;        ///< non-finite, or not later than the last
    std::size_t refused_observations = 0;  ///< non-finite, or with unusable covariance
    std::size_t motion_gaps = 0;           ///< times the motion input was older than hold_limit_s
    std::size_t scans_without_motion = 0;
    std::size_t observations = 0;
    std::size_t associated = 0;
    std::size_t rejected = 0;
    std::size_t bounded_associations = 0;  ///< scans too dense for association.max_nodes
    std::size_t slips = 0;                 ///< scans that only a worse motion explained
    std::size_t noisy_scans = 0;   ///< after a motion with at least twice the claimed deviations
    std::size_t places_found = 0;  ///< scans that told where the vehicle is, by all landmarks
    std::size_t scans_without_place = 0;  ///< of which nothing was made; see PlaceFinder
    std::size_t gps_used = 0;
    std::size_t gps_rejected = 0;
    std::size_t landmarks_created = 0;
    std::size_t landmarks_dropped = 0;
    std::size_t landmarks_merged = 0;
    std::size_t area_switches = 0;
    std::size_t global_updates = 0;
    std::size_t deferred_global_updates = 0;  ///< that waited for the one before
    std::size_t global_update_waits = 0;      ///< scans that waited, the active part being full
    std::size_t map_corrections =
        0;  ///< scans that moved an active landmark by over large_correction_m
    std::size_t iterated_updates = 0;
    std::size_t diverged_updates = 0;     ///< of these, that were refused for it
    std::size_t resets = 0;               ///< maps that were begun anew or loaded
    std::size_t resumed = 0;              ///< returns that were accepted, closing or not
    std::size_t refused_resumptions = 0;  ///< of either kind
    std::size_t forgotten_states = 0;     ///< scans given up early, see keepLocalStates()
  };

  /// CPU of the parts, in seconds, since construction.
  struct CpuTimes {
    double perception_s = 0.0;
    double filter_s = 0.0;  ///< on the calling thread, without what an inline worker did
    double worker_s = 0.0;  ///< global updates, and maps on request
  };

  /// On a thread of its own, a global update and a map cost a scan nothing. Inline, the same events
  /// give the same bits.
  using GlobalUpdates = SerialWorker::Mode;

  /// Throws ConfigError if the configuration is unusable.
  CekfSlam(const CekfSlamConfig& config, const VehicleConfig& vehicle,
           GlobalUpdates global_updates = GlobalUpdates::kInline);
  ~CekfSlam();
  CekfSlam(CekfSlam&&) noexcept;
  CekfSlam& operator=(CekfSlam&&) noexcept;

  /// Any event; the outcome of a scan or observation set, nothing for others.
  std::optional<ScanOutcome> process(const SensorEvent& event);

  /// A new, empty map with the vehicle at its origin. Ids start anew, the version goes on.
  void reset();

  PoseEstimate pose() const;
  Calibration calibration() const;
  Eigen::Matrix3d calibrationCovariance() const;
  LaserCalibration laserCalibration() const;
  /// How much larger the variances of the motion (translation, rotation) are than the vehicle's
  /// configuration claims, as innovations tell; at least 1.
  Eigen::Vector2d motionNoiseFactors() const;
  std::uint64_t mapVersion() const;
  std::size_t landmarkCount() const;

  /// Hands all landmarks as they are now (one epoch) to `take`, on the worker's thread, unless
  /// the engine is destroyed before. Cross-covariances for pairs no farther apart
  /// than `block_range_m` (0: none).
  void requestMap(double block_range_m, std::function<void(LandmarkMap)> take);
  /// The same, and waits for it.
  LandmarkMap landmarkMap(double block_range_m);

  /// Hands the joint estimate of landmarks as they are now to `take`, on the worker's thread.
  /// False, and nothing happens, if there is no landmark of one of these ids.
  bool requestJointLandmarks(const std::vector<int>& ids, std::function<void(JointLandmarks)> take);
  bool hasLandmark(int id) const;

  /// The same together with the vehicle: their joint Gaussian, with the covariance between both.
  /// While suspended it is as of T0.
  bool requestVehicleAmongLandmarks(const std::vector<int>& ids,
                                    std::function<void(VehicleAmongLandmarks)> take);

  // --- The way back: see cekf/resumption.h ----------------------------------------------------

  /// Keeps what it takes to go back to each scan of the last `duration_s` by stamps (0: to none, as
  /// at the start). Meanwhile a global update waits until no scan before it can be gone back to;
  /// when the active part would grow beyond twice its bound by that, the oldest scans are given up
  /// and counted as forgotten. Costs memory (see localStates()) and a copy of the landmarks'
  /// register every quarter of that time.
  void keepLocalStates(double duration_s);
  /// Nothing if there is none: not asked for, no scan yet, or just reset.
  std::optional<LocalStateSpan> localStates() const;

  /// Goes back to the scan with the stamp `time_T0_s`, and waits there. From now on events are kept
  /// for resume(), and used for the pose alone, which is carried along by the motion; map, joint
  /// estimates and calibration are as of T0. False, and nothing happens, if that scan is not kept.
  /// If suspended already: goes back farther, with what came since still kept. Ends with an
  /// accepted resumption, or with reset(). Scans are kept for at most `kLongestSuspension_s`;
  /// older ones are counted as forgotten and not gone over again. No motion is lost.
  bool suspend(double time_T0_s);
  bool isSuspended() const;
  static constexpr double kLongestSuspension_s = 300.0;

  /// Goes back to the scan at T0 and replays all events since, with the associations that `path`
  /// makes plain: poses at scans after T0, in the order of time, at least one. Scans before the
  /// first of them move the vehicle only. The first scan of the path that shows enough landmarks
  /// closes the loop: all of them jointly, linearised at the path, under a chi-square gate of
  /// 0.999; if they do not pass, the covariance of the vehicle's pose is taken up to 9 times. From
  /// there on scans are processed as ever. The path's errors do not enter the filter: it only tells
  /// which is which. If refused, all is as before, and those scans are kept still.
  Resumption resume(double time_T0_s, const std::vector<PlaceAtScan>& path);
  /// The same for a vehicle that was carried, or never was where it was taken to be: what the
  /// filter holds of the pose at T0 is given up first. It begins anew at the path, independent of
  /// all else and as good as unknown, so that the landmarks alone tell where the vehicle is.
  Resumption resumeElsewhere(double time_T0_s, const std::vector<PlaceAtScan>& path);
  /// Goes back to the scan at T0 and on to now as if nothing had been observed since: dead
  /// reckoning, no loop is closed. Refused only if the scan is not kept.
  Resumption resumeWithoutClosing(double time_T0_s);

  /// What changed since the last call, or since the start.
  LandmarkUpdate takeUpdate();

  /// Landmarks that must not be dropped, as of a stamp: what is told is in force for scans from
  /// landmarks.pin_delay_s later on. Such landmarks may still be merged. reset() forgets them.
  void pinLandmarks(double time_s, const std::vector<int>& ids);

  /// All that decides how the engine goes on, with every covariance, as bytes. Waits for a global
  /// update that is on its way, and otherwise changes nothing.
  std::string saveState();

  /// The map and the estimate that saveState() gave, in the place of the present ones; the version
  /// does not fall. If the next event comes while the last input still holds, the engine goes on as
  /// if it had never stopped; else the vehicle has stood still meanwhile. `name` leads the
  /// sentences of what is thrown: InputError, and nothing changed, if the bytes are damaged or do
  /// not suit the configuration. reset() ends what `use` says.
  void loadState(std::string_view bytes, const std::string& name, MapUse use);
  /// Throws what loadState() would.
  void checkState(std::string_view bytes, const std::string& name) const;

  /// The vehicle is here for certain, whatever was known of it before: `covariance` is that of
  /// (x [m], y [m], yaw [rad]), and independent of the map.
  void placeVehicle(const Pose2& T_map_base, const Eigen::Matrix3d& covariance);

  /// Whether a global update is on its way.
  bool isGlobalUpdatePending();

  Counts counts() const;
  CpuTimes cpuTimes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hymm::core
