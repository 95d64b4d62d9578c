#include "tools/offline_source.h"

#include <algorithm>
#include <utility>

#include <tf2/buffer_core.h>

#include "common/error.h"
#include "pipeline/suite_stages.h"
#include "ros/cause_log.h"
#include "ros/event_reader.h"
#include "ros/grid_conversions.h"
#include "ros/sensor_bag.h"
#include "ros/transform_lookup.h"

namespace hymm {
namespace {

std::string counted(const std::string& what, std::size_t count) {
  return what + ": " + std::to_string(count);
}

void addIncidents(const core::OfflineRun& run, std::vector<std::string>& notes) {
  for (const auto& [what, count] : run.incidents()) notes.push_back(counted(what, count));
  for (std::string& remark : run.remarks()) notes.push_back(std::move(remark));
}

EventReader eventReader(const tf2::BufferCore& tf, const core::SuiteConfig& config,
                        CauseLog& causes) {
  const core::VehicleConfig& vehicle = config.vehicle;
  std::optional<core::Pose2> laser;
  if (config.vehicle_tells_laser) laser = vehicle.laser.T_base_sensor();
  return EventReader(SensorMountings(tf, vehicle.base_frame, laser, 0.0),
                     GpsConverter({vehicle.gps_antenna.x_m, vehicle.gps_antenna.y_m}),
                     config.point_clouds, config.cekf_slam.use_time_increment, causes);
}

/// Reads property samples, which lie in map or in a frame that is fixed to the vehicle.
class SampleReader {
 public:
  SampleReader(const tf2::BufferCore& tf, const core::VehicleConfig& vehicle, CauseLog& causes)
      : map_frame_(withoutSlash(vehicle.map_frame)),
        odom_frame_(withoutSlash(vehicle.odom_frame)),
        mountings_(tf, vehicle.base_frame, std::nullopt, 0.0),
        causes_(causes) {}

  std::optional<core::RecordedSample> read(const PropertySample& message) {
    const std::string frame = withoutSlash(message.header.frame_id);
    core::RecordedSample recorded{fromMessage(message, core::Pose2()), std::nullopt};
    if (frame == map_frame_) return recorded;
    std::string problem =
        "it is not fixed to the vehicle, and hymm_offline places samples in map "
        "and in frames of the vehicle only";
    if (frame != odom_frame_) {
      const SensorMountings::Answer found = mountings_.findInSpace(frame, 0.0);
      recorded.T_base_frame = found.T_base_sensor;
      problem = found.problem;
    }
    if (recorded.T_base_frame) return recorded;
    causes_.count("property samples of frame '" + frame + "' without a place",
                  "Property samples of frame '" + frame + "' are refused: " + problem + ".");
    return std::nullopt;
  }

 private:
  std::string map_frame_, odom_frame_;
  SensorMountings mountings_;
  CauseLog& causes_;
};

}  // namespace

std::map<std::string, std::string> parseRemappings(const std::vector<std::string>& texts) {
  const std::vector<std::string> inputs = SensorBag::inputs();
  std::map<std::string, std::string> remappings;
  std::vector<std::string> problems;
  for (const std::string& text : texts) {
    const std::size_t sign = text.find(":=");
    if (sign == std::string::npos || sign == 0 || sign + 2 == text.size()) {
      problems.push_back("--topic '" + text + "' should be like scan:=/front/scan.");
      continue;
    }
    const std::string name = text.substr(0, sign);
    if (std::find(inputs.begin(), inputs.end(), name) == inputs.end()) {
      problems.push_back("--topic '" + text + "': '" + name + "' is no input; there are " +
                         core::listOf(inputs) + ".");
    }
    remappings[name] = text.substr(sign + 2);
  }
  if (!problems.empty()) throw core::ConfigError(problems);
  return remappings;
}

std::vector<std::string> runBag(const std::string& path,
                                const std::map<std::string, std::string>& remappings,
                                const core::SuiteConfig& config, core::OfflineRun& run,
                                const Progress& progress) {
  SensorBag bag(path, {config.cekf_slam.motion_input, config.cekf_slam.observation_input,
                       remappings, config.cekf_slam.gps.enabled});
  tf2::BufferCore tf;
  bag.readTransforms(tf, config.vehicle.base_frame);
  CauseLog causes;
  EventReader reader = eventReader(tf, config, causes);
  SampleReader samples(tf, config.vehicle, causes);
  const auto takeSensor = [&](const SensorMessage& message) {
    if (auto event = reader.read(message, 0.0).event) {
      // The next recording has its own transforms and its own GPS origin, as for a live node.
      if (run.process(std::move(*event))) reader.reset();
    } else if (isScan(message)) {
      run.countLostScan();
    }
  };
  const auto take = [&](const BagMessage& message) {
    if (const auto* sensor = std::get_if<SensorMessage>(&message)) {
      takeSensor(*sensor);
    } else if (auto sample = samples.read(*std::get<PropertySample::ConstPtr>(message))) {
      run.process(*sample);
    }
  };
  bag.read(take, progress);
  run.finish();

  std::vector<std::string> notes = bag.stamps().problems();
  for (const auto& [what, count] : bag.incidents()) notes.push_back(counted(what, count));
  for (const auto& [cause, count] : causes.counts()) notes.push_back(counted(cause, count));
  if (const std::string summary = reader.summary(); !summary.empty()) notes.push_back(summary);
  addIncidents(run, notes);
  if (run.scans() > 0 && bag.stamps().areApart()) {
    throw core::InputError(path +
                           ": motion and scans are not of one time; nothing was estimated. " +
                           bag.stamps().problems().back());
  }
  return notes;
}

core::LandmarkRecording readDataset(const std::string& kind, const std::string& path, int robot) {
  if (kind == "mrclam") return core::readMrclam(path, robot);
  if (kind == "dlr") return core::readDlr(path);
  throw core::InputError("--dataset " + kind + ": is not known; there are mrclam and dlr.");
}

std::vector<std::string> runRecording(const core::LandmarkRecording& recording,
                                      core::OfflineRun& run, const Progress& progress) {
  const auto total = static_cast<double>(recording.events.size());
  double seen = 0.0;
  for (const core::SensorEvent& event : recording.events) {
    run.process(event);
    progress(++seen / total);
  }
  run.finish();
  std::vector<std::string> notes;
  for (const auto& [what, count] : recording.counts) notes.push_back(counted(what, count));
  addIncidents(run, notes);
  return notes;
}

}  // namespace hymm
