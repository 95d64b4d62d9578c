#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "datasets/landmark_recording.h"
#include "pipeline/offline_run.h"
#include "pipeline/suite_config.h"

namespace hymm {

using Progress = std::function<void(double)>;

/// "scan:=/front/scan" and its like, by our name. Throws core::ConfigError for anything else.
std::map<std::string, std::string> parseRemappings(const std::vector<std::string>& texts);

/// Feeds a bag to a run, through the same reading of messages as the live nodes, and finishes the
/// run. Returns sentences about what was found, skipped and refused. Throws core::InputError.
std::vector<std::string> runBag(const std::string& path,
                                const std::map<std::string, std::string>& remappings,
                                const core::SuiteConfig& config, core::OfflineRun& run,
                                const Progress& progress);

/// Reads a public recording: `kind` is mrclam or dlr. Throws core::InputError.
core::LandmarkRecording readDataset(const std::string& kind, const std::string& path, int robot);

/// Feeds a recording to a run and finishes it, as runBag() does.
std::vector<std::string> runRecording(const core::LandmarkRecording& recording,
                                      core::OfflineRun& run, const Progress& progress);

}  // namespace hymm
