#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cekf/cekf_slam.h"
#include "cekf/map_schedule.h"
#include "pipeline/observation_log.h"
#include "pipeline/results_writer.h"
#include "pipeline/sensor_merger.h"
#include "pipeline/sight_report.h"
#include "pipeline/suite_config.h"
#include "pipeline/suite_stage.h"
#include "pipeline/supervisor_stage.h"

namespace hymm::core {

/// All engines in one process, driven by a recording as fast as they can work. The same events
/// give the same results, times that the machine took aside.
class OfflineRun {
 public:
  /// `nodes`: those to run, by name (see chosenNodes). Throws ConfigError if the configuration is
  /// unusable. `results` outlives the run.
  OfflineRun(const SuiteConfig& config, const std::vector<std::string>& nodes,
             ResultsWriter& results);

  /// Begins with a saved map, before the first event; `pose`: where the vehicle is in it, if not
  /// where it was when the map was saved. Returns sentences worth telling. Throws InputError.
  std::vector<std::string> loadMap(const std::string& folder, MapUse use,
                                   const std::optional<Pose2>& pose);
  /// Saves the map that the run ended with. Throws OutputError.
  void saveMap(const std::string& folder);

  /// Logs each observation as well; `log` outlives the run.
  void logObservations(ObservationLog& log) { log_ = &log; }

  /// Takes an event in the order of the recording; one whose stamp is not finite is refused.
  /// Returns whether another recording began with it.
  bool process(SensorEvent event);

  /// Takes a property that another sensor measured.
  void process(const RecordedSample& sample);

  /// Counts a scan of the recording that could not become an event.
  void countLostScan() { ++scans_in_; }

  /// Processes what waited for later events. Nothing may be processed afterwards.
  void finish();

  /// Scans that the filter took so far.
  std::size_t scans() const { return filter_.counts().scans; }

  /// Motion inputs that moved the filter.
  std::size_t motionInputs() const {
    const std::size_t refused = filter_.counts().refused_motion;
    return motion_inputs_ > refused ? motion_inputs_ - refused : 0;
  }

  /// Landmarks of the map that the run ended with.
  LandmarkMap landmarkMap() { return filter_.landmarkMap(0.0); }

  /// Who was in charge of the last scan, and why; null without a supervisor.
  const SupervisorStage* supervisor() const { return supervisor_; }

  /// The part of the totals that the engines know.
  RunTotals totals() const;

  /// Writes the files of the engines behind the filter. Throws OutputError.
  void writeFiles(const std::string& folder);

  /// What was refused or reset, by cause, and how often.
  std::map<std::string, std::size_t> incidents() const;

  /// What it looked for in vain: sentences.
  std::vector<std::string> remarks() const {
    return sights_.sentences(filter_.counts(), filter_.landmarkCount());
  }

 private:
  void processReleased(const SensorEvent& event);
  void finishScan(const SensorEvent& event, const ScanOutcome& outcome);
  void serveStages(const SensorEvent& event, const ScanOutcome& outcome);
  void record(const ScanOutcome& outcome);

  SuiteConfig config_;
  ResultsWriter& results_;
  ObservationLog* log_ = nullptr;
  SensorMerger merger_;
  CekfSlam filter_;
  SightReport sights_;
  MapSchedule map_schedule_;
  std::vector<std::unique_ptr<SuiteStage>> stages_;
  const SupervisorStage* supervisor_;  ///< one of the stages, if it runs
  std::size_t map_corrections_ = 0;    ///< up to the last scan
  std::size_t scans_in_ = 0;
  std::size_t motion_inputs_ = 0;  ///< that the filter was given
  std::map<std::string, std::size_t> incidents_;
};

}  // namespace hymm::core
