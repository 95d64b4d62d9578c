#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/FilterHealth.h>
#include <hymm/FilterPose.h>
#include <hymm/FilterStatus.h>
#include <hymm/GridStatus.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>
#include <hymm/LtrMap.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <sensor_msgs/NavSatFix.h>

#include "common/error.h"
#include "nodes/recorder_config.h"
#include "pipeline/landmark_mirror.h"
#include "pipeline/results_writer.h"
#include "ros/cause_log.h"
#include "ros/filter_pairing.h"
#include "ros/gps_converter.h"
#include "ros/grid_record.h"
#include "ros/level_set_record.h"
#include "ros/recording_break.h"
#include "ros/traffic_meter.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// The node `recorder`: writes what the live nodes find into the folder that `hymm_offline` would
/// write, in the order of stamps. All of it is saved now and then, so that even a node that is
/// killed leaves a complete folder, of a moment before. What cannot be saved is kept, and saved
/// when that is possible again. Until the first scan the folder stays as it is.
class RecorderNode {
 public:
  /// `seed`: of the run's randomness, the relocaliser's. Throws OutputError if the folder cannot be
  /// written.
  RecorderNode(const RecorderConfig& config, const core::VehicleConfig& vehicle, int seed);

  /// Writes what is left; nothing may come afterwards. Throws OutputError.
  void finish();

 private:
  void takePose(const FilterPose& message);
  void takeHealth(const FilterHealth& message);
  void takePoseInCharge(const geometry_msgs::PoseWithCovarianceStamped& message);
  void takeMap(const LandmarkMap& message);
  void takeUpdate(const LandmarkUpdate& message);
  void takeGps(const sensor_msgs::NavSatFix& message);
  void takeStatus(const FilterStatus& message);

  void addPairs();
  void addScan(const FilterAnswer& answer);
  void beginAnew(const ros::Time& stamp, core::FilterCourse course);
  void write(double up_to_s);
  void writeFix(const sensor_msgs::NavSatFix& message);
  void writeLateFixes();
  void wait(const std::deque<sensor_msgs::NavSatFix>& fixes);
  void switchMode(const FilterStatus& status);
  void writeScan(core::ScanRecord scan);
  bool isWaitingForMode() const;
  bool isQuiet() const;
  void save();
  void tellNotSaved(const core::OutputError& error);
  core::RunTotals totals() const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  core::VehicleConfig vehicle_;
  std::size_t seed_;
  std::string output_;
  core::ResultsWriter writer_;
  CauseLog causes_;
  GridRecord grid_;
  LevelSetRecord level_sets_;
  TrafficMeter traffic_;
  GpsConverter gps_;
  core::LandmarkMirror landmarks_;
  std::string mode_;                   ///< of the last scan that was written
  std::deque<FilterStatus> statuses_;  ///< that switched it later, as they came
  FilterPairing pairing_;
  std::multimap<double, core::ScanRecord> scans_;              ///< by stamp, to be written
  std::map<double, geometry_msgs::PoseWithCovariance> poses_;  ///< of the filter in charge
  std::multimap<double, sensor_msgs::NavSatFix> fixes_;        ///< by stamp, to be written
  std::deque<sensor_msgs::NavSatFix> late_fixes_;  ///< or of a recording that no scan tells yet
  core::FilterLife filter_;                        ///< by its answers
  std::size_t restarts_ = 0;
  std::optional<FilterHealth> last_health_;
  double begin_wall_s_;
  double last_scan_wall_s_ = 0.0;
  std::size_t written_scans_ = 0;
  bool is_saved_ = true;       ///< what was last tried to be saved
  double saved_wall_s_ = 0.0;  ///< when the folder was last complete
  double save_ms_ = 0.0;       ///< what that took

  ros::NodeHandle handle_;
  std::vector<ros::Subscriber> subscribers_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer save_timer_, diagnostics_timer_;
};

}  // namespace hymm
