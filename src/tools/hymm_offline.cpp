#include <chrono>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "common/progress_bar.h"
#include "datasets/landmark_recording.h"
#include "pipeline/offline_run.h"
#include "pipeline/results_writer.h"
#include "pipeline/suite_config.h"
#include "pipeline/suite_stages.h"
#include "ros/parameters.h"
#include "ros/process_usage.h"
#include "storage/map_folder.h"
#include "tools/offline_source.h"

namespace hymm {
namespace {

struct Options {
  std::string bag;
  std::vector<std::string> dataset;  // its kind and its path
  int robot = 1;
  std::vector<std::string> configs;
  std::string output;
  std::optional<int> seed;
  bool observations = false;
  std::vector<std::string> only;
  std::vector<std::string> topics;
  std::string load, save;
  bool localise_only = false;
  std::vector<double> start;  // x, y, yaw
};

void describe(CLI::App& app, Options& options) {
  auto* source = app.add_option_group("source");
  source->add_option("--bag", options.bag, "bag to run on");
  source
      ->add_option("--dataset", options.dataset,
                   "public recording to run on: mrclam PATH, or dlr PATH")
      ->expected(2);
  source->require_option(1);
  app.add_option("--robot", options.robot, "robot of an MRCLAM recording")->capture_default_str();
  app.add_option(
      "--config", options.configs,
      "YAML files, in order over the built-in defaults; without any, the one that is shipped "
      "for a --dataset");
  app.add_option("--output", options.output, "folder for the results; made if missing")->required();
  app.add_option("--seed", options.seed, "of all randomness; default: relocaliser/seed")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  app.add_flag("--observations", options.observations,
               "also write observations.csv: each observation and its landmark");
  app.add_option("--only", options.only,
                 "subsystems to run, by their nodes' names, comma-separated; all if not given: " +
                     core::listOf(core::nodeNames()))
      ->delimiter(',');
  auto* load = app.add_option("--load", options.load, "folder of a saved map to begin with");
  app.add_flag("--localise-only", options.localise_only,
               "leave that map as it is, and estimate the vehicle alone")
      ->needs(load);
  app.add_option("--start", options.start,
                 "where base_link is in that map (m, m, rad); else where it was at the end")
      ->expected(3)
      ->needs(load);
  app.add_option("--save", options.save, "folder to save the map in that the run ends with");
  app.add_option("--topic", options.topics, "another name of a topic, as scan:=/front/scan");
}

/// Without any of its own, a public recording has the one that is shipped for its kind.
std::vector<std::string> configsOf(const Options& options) {
  if (options.dataset.empty() || !options.configs.empty()) return options.configs;
  const std::string shipped = configFolder() + "/datasets/" + options.dataset.front() + ".yaml";
  if (std::filesystem::exists(shipped)) return {shipped};
  std::cerr << "Warning: " << shipped << " is not there; the built-in defaults are used.\n";
  return {};
}

core::SuiteConfig readConfig(const Options& options) {
  core::ConfigReport report;
  core::SuiteConfig config = core::loadSuiteConfig(configsOf(options), report, configFolder);
  config.relocaliser.seed = options.seed.value_or(config.relocaliser.seed);
  for (const std::string& warning : report.warnings) std::cerr << "Warning: " << warning << '\n';
  report.throwIfUnusable();
  return config;
}

std::vector<std::string> run(const Options& options, const core::SuiteConfig& config,
                             core::OfflineRun& offline) {
  constexpr double kSteps = 1000.0;
  core::ProgressBar bar("Running", static_cast<std::size_t>(kSteps));
  const auto progress = [&](double share) { bar.update(static_cast<std::size_t>(share * kSteps)); };
  if (!options.bag.empty()) {
    return runBag(options.bag, parseRemappings(options.topics), config, offline, progress);
  }
  return runRecording(readDataset(options.dataset.at(0), options.dataset.at(1), options.robot),
                      offline, progress);
}

std::vector<std::string> loadMap(const Options& options, core::OfflineRun& offline) {
  if (options.load.empty()) return {};
  std::optional<core::Pose2> start;
  if (!options.start.empty())
    start = core::Pose2{options.start[0], options.start[1], options.start[2]};
  const auto use = options.localise_only ? core::MapUse::kLocalise : core::MapUse::kExtend;
  return offline.loadMap(options.load, use, start);
}

/// Whether the map can be saved is known before the run, not after it.
void prepareSave(const Options& options) {
  if (options.save.empty()) return;
  std::error_code ignored;
  if (std::filesystem::equivalent(options.save, options.output, ignored)) {
    throw core::InputError("--save and --output name the same folder, " + options.output +
                           "; give the map a folder of its own.");
  }
  core::MapFolder(options.save).prepare();
}

void runOffline(const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<std::string> nodes = core::chosenNodes(options.only);
  const core::SuiteConfig config = readConfig(options);
  core::ResultsWriter results(options.output);
  prepareSave(options);
  core::OfflineRun offline(config, nodes, results);
  std::optional<core::ObservationLog> log;
  if (options.observations) offline.logObservations(log.emplace(options.output));
  std::vector<std::string> notes = loadMap(options, offline);
  const std::vector<std::string> run_notes = run(options, config, offline);
  notes.insert(notes.end(), run_notes.begin(), run_notes.end());
  for (const std::string& note : notes) std::cerr << note << '\n';
  if (offline.scans() == 0) throw core::InputError("No scan could be used; nothing was estimated.");
  if (offline.motionInputs() == 0) {
    throw core::InputError(
        "No motion input could be used, so that every scan was taken at one place; nothing was "
        "estimated. What is wrong with the messages stands above.");
  }

  if (log) log->finish();
  offline.writeFiles(options.output);
  core::RunTotals totals = offline.totals();
  totals.notes = notes;
  totals.seed = static_cast<std::size_t>(config.relocaliser.seed);
  const ProcessUsage usage = processUsage();
  totals.peak_rss_mb = usage.peak_rss_mb;
  totals.cpu_s = usage.cpu_s;
  totals.addOtherCpu();
  totals.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  results.finish(offline.landmarkMap(), totals);
  // Last, so that a map that cannot be saved does not cost the results.
  if (!options.save.empty()) offline.saveMap(options.save);
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  CLI::App app{"Runs the suite on a recording, in one process and as fast as the machine can."};
  hymm::Options options;
  hymm::describe(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    hymm::runOffline(options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "hymm_offline: " << error.what() << '\n';
    return 1;
  }
}
