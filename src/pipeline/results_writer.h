#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_map.h"
#include "evaluation/gps_alignment.h"
#include "pipeline/latency_histogram.h"
#include "pipeline/line_file.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// One scan (or observation set) that the filter took.
struct ScanRecord {
  PoseEstimate pose;
  FilterHealth health;
  std::string mode;  ///< of the supervisor: which filter is in charge
};

/// What only the end of a run knows. Counts are of the whole run, as CekfSlam::Counts has them.
struct RunTotals {
  double wall_s = 0.0;       ///< from the start, reading and writing included
  double cpu_s = 0.0;        ///< of the whole process
  double peak_rss_mb = 0.0;  ///< MB of 10^6 bytes
  std::map<std::string, double> subsystem_cpu_s;
  std::size_t dropped_scans = 0;  ///< that came, but have no line in trajectory.tum
  std::size_t ltrs = 0;           ///< of the map at the end
  std::size_t observations = 0;
  std::size_t associated = 0;
  std::size_t rejected = 0;
  std::size_t map_corrections = 0;
  std::size_t global_updates = 0;
  std::size_t deferred_global_updates = 0;
  std::size_t global_update_waits = 0;
  std::optional<Eigen::Vector2d> gps_antenna_m;  ///< place in base_link, for hymm_evaluate
  std::size_t seed = 0;
  std::vector<std::string> notes;  ///< sentences about the input that whoever reads should know

  /// Adds what cpu_s holds beyond the subsystems as the subsystem `other`.
  void addOtherCpu();
};

/// Writes the folder of results that `hymm_offline --output DIR` and `playback.launch output:=DIR`
/// leave (trajectory.tum, pose_covariance.csv, landmarks.csv, health.csv, gps.csv,
/// events.csv, summary.json). Lines go to disk as records come, of all files at once, so that
/// memory does not grow with the run and the files fit each other however the run ends. Where they
/// cannot be written, they wait, and nothing is lost if they can later. Numbers are
/// written with the fewest digits that give the same double back, whatever the locale. Times that
/// the machine took stand only in latency_ms of health.csv and in wall_s, cpu_s, real_time_factor,
/// peak_rss_mb, scan_latency_ms, worker_ms and subsystem_cpu_s of summary.json: everything else is
/// a function of the input.
class ResultsWriter {
 public:
  /// Makes the folder. What an earlier run left there stays until the first scan, or the end: a run
  /// without a scan has nothing to put in its place. Then it is removed (see removeResults()).
  /// Throws OutputError if the folder cannot be written.
  explicit ResultsWriter(const std::string& folder);

  /// Throws OutputError if the lines up to here could not be written; they are kept all the same,
  /// this scan's among them, and are written when that is possible again.
  void addScan(const ScanRecord& record);

  /// A fix, in order of time with the scans, whether or not the filter used it.
  void addGps(const GpsFix& fix);

  /// The supervisor changed its mode (the mode in which a run begins is no switch).
  void addModeSwitch(double time_s, const std::string& mode, const std::string& reason);

  /// The filter began a new map: poses from here on are in another map frame.
  void addReset(double time_s, const std::string& reason);

  /// Leaves a complete folder of the run so far, in case that it cannot finish: all lines, then
  /// landmarks.csv and, last of all, summary.json, which says so in its notes; each of these two
  /// replaces the one before at once. Throws OutputError if anything could not be written.
  void save(const LandmarkMap& map, const RunTotals& totals);

  /// The same at the end of the run. Nothing may be added afterwards.
  void finish(const LandmarkMap& map, const RunTotals& totals);

 private:
  void addEvent(double time_s, const char* event, const std::string& reason);
  std::vector<LineFile*> files();
  void flushIfMuchWaits();
  void flushLines();
  std::string summaryText(const LandmarkMap& map, const RunTotals& totals) const;

  std::filesystem::path folder_;
  LineFile trajectory_, covariance_, health_, gps_, events_;
  bool is_begun_ = false;             ///< the folder holds nothing of an earlier run
  std::size_t next_flush_bytes_ = 0;  ///< that wait
  std::string mode_;

  std::size_t scans_ = 0;
  std::optional<double> first_s_, last_s_;  ///< stamps since the last reset
  double duration_s_ = 0.0;                 ///< of the recordings before the last reset
  std::size_t mode_switches_ = 0, resets_ = 0, gps_fixes_ = 0;
  double nis_ = 0.0;
  long dof_ = 0;
  LatencyHistogram latency_;
  GpsAlignment gps_alignment_;
};

}  // namespace hymm::core
