#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "datasets/landmark_recording.h"
#include "evaluation/evaluation_report.h"
#include "evaluation/run_results.h"
#include "ros/truth_bag.h"
#include "tools/above_zero.h"

namespace hymm {
namespace {

constexpr const char* kDescription =
    "Errors of a run's results, as JSON on stdout; what cannot be computed is null, and stderr "
    "says "
    "why.\n\n"
    "GPS: distance of the antenna's estimated place, interpolated at the fix's time, from the fix, "
    "after one rigid 2D motion (no scale) per window. A fix is left out if its distance from the "
    "last one kept could only be driven at more than 15 m/s.\n"
    "Truth: /truth/pose and /truth/landmarks of --bag, or of --dataset; errors as they are, and "
    "after one rigid motion (aligned); NEES against pose_covariance.csv and landmarks.csv.\n"
    "Landmarks are matched one to one, nearest first, within --gate after alignment.";

struct Options {
  std::string results;
  std::string bag;
  std::vector<std::string> dataset;  // its kind and its path
  int robot = 1;
  std::string gps;
  std::string landmarks;
  std::vector<double> antenna;
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
  double gate_m = 1.0;
  double missed_range_m = 20.0;
};

void describe(CLI::App& app, Options& options) {
  app.add_option("--results", options.results, "folder that hymm_offline or a playback left")
      ->required();
  auto* bag = app.add_option("--bag", options.bag, "simulated bag with the truth");
  app.add_option("--dataset", options.dataset, "recording with the truth: mrclam PATH")
      ->expected(2)
      ->excludes(bag);
  app.add_option("--robot", options.robot, "robot of an MRCLAM recording")->capture_default_str();
  app.add_option("--gps", options.gps,
                 "fixes: CSV with columns t,x,y, or ACFR's GPS.txt (time, north, east); "
                 "default: gps.csv of the results");
  app.add_option("--landmarks", options.landmarks,
                 "surveyed landmarks in the frame of the GPS: CSV with columns x,y");
  app.add_option("--antenna", options.antenna,
                 "place of the GPS antenna in base_link, m; default: as in the results")
      ->expected(2);
  app.add_option("--from", options.from_s, "begin of the window, s");
  app.add_option("--to", options.to_s, "end of the window, s");
  app.add_option("--gate", options.gate_m, "longest distance of a matched landmark, m")
      ->capture_default_str()
      ->check(aboveZero());
  app.add_option("--missed-range", options.missed_range_m,
                 "a true landmark that came no nearer to the vehicle is not missed, m")
      ->capture_default_str()
      ->check(aboveZero());
}

void addDatasetTruth(const Options& options, core::Reference& reference) {
  if (options.dataset.at(0) != "mrclam") {
    throw core::InputError("--dataset " + options.dataset.at(0) +
                           ": has no truth; mrclam is the one that has.");
  }
  const core::LandmarkRecording recording = core::readMrclam(options.dataset.at(1), options.robot);
  for (const core::TimedPose& pose : recording.truth_poses) {
    reference.poses.push_back({pose.time_s, pose.T_world_base});
  }
  for (const core::TruthLandmark& landmark : recording.truth_landmarks) {
    reference.landmarks.push_back(landmark.position);
  }
  reference.in_map_frame = false;
}

core::Reference readReference(const Options& options, const core::RunResults& results) {
  core::Reference reference;
  if (!options.bag.empty()) {
    Truth truth = readTruth(options.bag);
    if (truth.poses.empty() && truth.landmarks.empty()) {
      std::cerr << options.bag << ": has neither /truth/pose nor /truth/landmarks.\n";
    }
    reference.poses = std::move(truth.poses);
    reference.landmarks = std::move(truth.landmarks);
  } else if (!options.dataset.empty()) {
    addDatasetTruth(options, reference);
  }
  if (!options.landmarks.empty()) {
    reference.landmarks = core::readSurvey(options.landmarks);
    reference.landmarks_in_gps_frame = true;
  }
  reference.fixes = options.gps.empty() ? results.gps : core::readFixes(options.gps);
  reference.gps_antenna = results.gps_antenna;
  if (!options.antenna.empty()) {
    reference.gps_antenna = Eigen::Vector2d(options.antenna[0], options.antenna[1]);
  }
  return reference;
}

void runEvaluate(const Options& options) {
  const core::RunResults results = core::readRunResults(options.results);
  const core::Reference reference = readReference(options, results);
  const core::EvaluationReport report = core::evaluate(
      results, reference, {{options.from_s, options.to_s}, options.gate_m, options.missed_range_m});
  for (const std::string& remark : report.remarks) std::cerr << remark << '\n';
  std::cout << report.json.text() << '\n';
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  CLI::App app{hymm::kDescription};
  hymm::Options options;
  hymm::describe(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    hymm::runEvaluate(options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "hymm_evaluate: " << error.what() << '\n';
    return 1;
  }
}
