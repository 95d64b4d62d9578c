#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_map.h"
#include "pipeline/results_writer.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// What the filter made of a scan, for the engines behind it.
struct ScanStep {
  const SensorEvent& event;  ///< the scan or observation set
  const ScanOutcome& outcome;
  const LandmarkUpdate& update;            ///< since the scan before
  std::shared_ptr<const LandmarkMap> map;  ///< of the same version, where MapSchedule has one due
};

/// An engine behind the filter, as OfflineRun drives it: told of everything in the order of time,
/// asked at the end for its figures and files. There is one for each node of that kind, in a file
/// of its own; makeStages() knows them all.
class SuiteStage {
 public:
  virtual ~SuiteStage() = default;

  /// Any event, before the filter takes it.
  virtual void takeEvent(const SensorEvent&) {}
  /// After the filter accepted a scan. What the engine tells the filter goes to `filter`.
  virtual void takeScan(const ScanStep& step, CekfSlam& filter) = 0;
  /// The filter began a new map.
  virtual void reset(double time_s) = 0;

  /// Adds its CPU time under its node's name, and whatever figures it owns.
  virtual void addTo(RunTotals& totals) const = 0;
  /// What was refused, by cause, and how often.
  virtual std::map<std::string, std::size_t> incidents() const = 0;
  /// Writes its files into the folder of results. Throws OutputError.
  virtual void write(const std::filesystem::path& folder) = 0;
};

}  // namespace hymm::core
