#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "cekf/cekf_slam.h"
#include "cekf/landmark_map.h"
#include "pipeline/recorded_samples.h"
#include "pipeline/results_writer.h"
#include "pipeline/sensor_event.h"
#include "storage/map_folder.h"

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
  /// A property that another sensor measured; its time may lie before or after the last scan's.
  virtual void takeSample(const RecordedSample&) {}
  /// After the filter accepted a scan. What the engine tells the filter goes to `filter`.
  virtual void takeScan(const ScanStep& step, CekfSlam& filter) = 0;
  /// The filter began a new map.
  virtual void reset(double time_s) = 0;

  /// The engine's part of a saved map, all of the version that the filter's landmarks have; nothing
  /// if it owns none.
  struct NamedPart {
    std::string name;
    MapPart part;
  };
  virtual std::optional<NamedPart> savedPart() const { return std::nullopt; }
  /// The name of that part; empty if there is none.
  virtual std::string partName() const { return {}; }
  /// That part again, its landmarks being of `landmark_version` now. Throws InputError.
  virtual void load(const NamedPart&, std::uint64_t /*landmark_version*/, MapUse) {}
  virtual SavedSettings settings() const { return {}; }

  /// Adds its CPU time under its node's name, and whatever figures it owns.
  virtual void addTo(RunTotals& totals) const = 0;
  /// What was refused, by cause, and how often.
  virtual std::map<std::string, std::size_t> incidents() const = 0;
  /// Writes its files into the folder of results. Throws OutputError.
  virtual void write(const std::filesystem::path& folder) = 0;
};

}  // namespace hymm::core
