// Runs the landmark detector over a simulated drive or a recording and writes what it saw, and
// what it could have seen, as tables. scripts/experiments/detector makes figures of them.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "common/progress_bar.h"
#include "datasets/acfr_recording.h"
#include "perception/perception.h"
#include "pipeline/suite_config.h"
#include "simulation/simulation.h"
#include "tools/above_zero.h"

namespace hymm {
namespace {

/// A detection further than this from every landmark of its type is of something else.
constexpr double kMatchDistance_m = 0.5;

struct Arguments {
  std::string world;
  std::uint64_t seed = 1;
  int laps = 1;
  double duration_s = 0.0;
  int every = 1;
  std::vector<std::filesystem::path> recording;
  std::vector<std::string> configs;
  std::vector<std::size_t> point_scans;
  std::filesystem::path output;
};

/// A landmark of the simulated world as the laser stands to it.
struct LandmarkInView {
  int id = -1;
  core::LandmarkType type = core::LandmarkType::kUnknown;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in the laser's frame
  double diameter_m = 0.0;
  int beams = 0;     ///< whose first meeting is with it
  int expected = 0;  ///< that would meet it if nothing stood before it
  bool inside =
      false;  ///< whether its whole width is within the field of view, with a beam to spare

  double range() const { return position.norm(); }
  double bearing() const { return std::atan2(position.y(), position.x()); }
};

/// Landmarks that at least one beam met, or would have met without what stands before them.
std::vector<LandmarkInView> landmarksInView(const core::Simulation& simulation,
                                            const core::LaserScan& scan,
                                            const core::Pose2& T_map_laser,
                                            const std::vector<int>& beam_landmarks) {
  const double spacing = std::abs(scan.angle_increment_rad);
  const core::Pose2 T_laser_map = inverse(T_map_laser);
  std::vector<LandmarkInView> in_view;
  for (const core::TrueLandmark& landmark : simulation.landmarks()) {
    LandmarkInView view;
    view.id = landmark.id;
    view.type = landmark.type;
    view.position = T_laser_map * landmark.position;
    view.diameter_m = landmark.diameter_m;
    if (view.range() <= landmark.diameter_m || view.range() > scan.range_max_m) continue;
    const double half_width = std::asin(0.5 * landmark.diameter_m / view.range());
    // Place of its edges in beams from the first; a full turn is not simulated here.
    const double middle = (view.bearing() - scan.angle_min_rad) / scan.angle_increment_rad;
    const double first = std::ceil(middle - half_width / spacing);
    const double last = std::floor(middle + half_width / spacing);
    const double end = static_cast<double>(scan.ranges_m.size()) - 1.0;
    view.expected = static_cast<int>(std::max(0.0, last - first + 1.0));
    view.inside = first >= 1.0 && last <= end - 1.0;
    view.beams =
        static_cast<int>(std::count(beam_landmarks.begin(), beam_landmarks.end(), landmark.id));
    if (view.beams > 0 || (view.inside && view.expected > 0)) in_view.push_back(view);
  }
  return in_view;
}

/// The tables. Observations have the landmark they are of (-1: none) and its truth (nan: none);
/// landmarks in view tell whether they were seen.
class Tables {
 public:
  explicit Tables(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    open(observations_, folder / "observations.csv",
         "scan,landmark,type,range_m,bearing_rad,diameter_m,range_variance,covariance,"
         "bearing_variance,diameter_variance,true_range_m,true_bearing_rad,true_diameter_m");
    open(landmarks_, folder / "landmarks.csv",
         "scan,landmark,type,range_m,bearing_rad,diameter_m,beams,expected_beams,inside,seen");
    open(points_, folder / "points.csv", "scan,range_m,bearing_rad");
  }

  void addPoints(std::size_t scan, const core::LaserScan& laser) {
    for (std::size_t i = 0; i < laser.ranges_m.size(); ++i) {
      if (!std::isfinite(laser.ranges_m[i])) continue;
      points_ << scan << ',' << laser.ranges_m[i] << ',' << laser.bearing(i) << '\n';
    }
  }

  void addObservation(std::size_t scan, const core::Observation& seen,
                      const LandmarkInView* truth) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    observations_ << scan << ',' << (truth ? truth->id : -1) << ',' << static_cast<int>(seen.type)
                  << ',' << seen.range_m << ',' << seen.bearing_rad << ',' << seen.diameter_m << ','
                  << seen.covariance(0, 0) << ',' << seen.covariance(0, 1) << ','
                  << seen.covariance(1, 1) << ',' << seen.diameter_variance << ','
                  << (truth ? truth->range() : nan) << ',' << (truth ? truth->bearing() : nan)
                  << ',' << (truth ? truth->diameter_m : nan) << '\n';
  }

  void addLandmark(std::size_t scan, const LandmarkInView& view, bool seen) {
    landmarks_ << scan << ',' << view.id << ',' << static_cast<int>(view.type) << ','
               << view.range() << ',' << view.bearing() << ',' << view.diameter_m << ','
               << view.beams << ',' << view.expected << ',' << view.inside << ',' << seen << '\n';
  }

 private:
  static void open(std::ofstream& file, const std::filesystem::path& path, const char* header) {
    file.open(path);
    if (!file) throw core::InputError("Cannot write " + path.string() + ".");
    file.precision(9);
    file << header << '\n';
  }

  std::ofstream observations_, landmarks_, points_;
};

double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The detector with a clock.
class TimedDetector {
 public:
  explicit TimedDetector(const core::PerceptionConfig& config) : perception_(config) {}

  std::vector<core::Observation> detect(const core::LaserScan& scan) {
    const double begin = cpuSeconds();
    std::vector<core::Observation> found = perception_.detect(scan);
    seconds_ += cpuSeconds() - begin;
    ++scans_;
    observations_ += found.size();
    return found;
  }

  void print() const {
    std::printf("{\"scans\": %zu, \"observations\": %zu, \"detect_cpu_us_per_scan\": %.2f}\n",
                scans_, observations_, scans_ ? 1e6 * seconds_ / static_cast<double>(scans_) : 0.0);
  }

 private:
  core::Perception perception_;
  double seconds_ = 0.0;
  std::size_t scans_ = 0, observations_ = 0;
};

Eigen::Vector2d positionOf(const core::Observation& seen) {
  return {seen.range_m * std::cos(seen.bearing_rad), seen.range_m * std::sin(seen.bearing_rad)};
}

/// Gives each observation the nearest landmark of its type that no nearer observation has.
void recordScan(std::size_t scan, const std::vector<core::Observation>& found,
                const std::vector<LandmarkInView>& in_view, Tables& tables) {
  struct Pair {
    double distance_m;
    std::size_t observation, landmark;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t j = 0; j < in_view.size(); ++j) {
      if (found[i].type != in_view[j].type) continue;
      const double distance = (positionOf(found[i]) - in_view[j].position).norm();
      if (distance < kMatchDistance_m) pairs.push_back({distance, i, j});
    }
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
  std::vector<const LandmarkInView*> landmark_of(found.size(), nullptr);
  std::vector<bool> seen(in_view.size(), false);
  for (const Pair& pair : pairs) {
    if (landmark_of[pair.observation] || seen[pair.landmark]) continue;
    landmark_of[pair.observation] = &in_view[pair.landmark];
    seen[pair.landmark] = true;
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    tables.addObservation(scan, found[i], landmark_of[i]);
  }
  for (std::size_t j = 0; j < in_view.size(); ++j) tables.addLandmark(scan, in_view[j], seen[j]);
}

bool wantsPoints(const Arguments& arguments, std::size_t scan) {
  const auto& wanted = arguments.point_scans;
  return std::find(wanted.begin(), wanted.end(), scan) != wanted.end();
}

void runWorld(const Arguments& arguments, TimedDetector& detector, Tables& tables) {
  core::SimulationConfig config;
  config.world.name = arguments.world;
  config.drive.laps = arguments.laps;
  config.drive.duration_s = arguments.duration_s;
  config.gps.enabled = false;
  core::Simulation simulation(config, core::simulatedCar(), arguments.seed);
  core::ProgressBar progress("Driving", 1000);
  std::size_t scan = 0;
  while (const auto simulated = simulation.next()) {
    const auto* event = std::get_if<core::ScanEvent>(&simulated->event);
    if (!event) continue;
    progress.update(static_cast<std::size_t>(1000.0 * simulation.progress()));
    const std::size_t index = scan++;
    if (index % static_cast<std::size_t>(arguments.every) != 0) continue;
    recordScan(index, detector.detect(event->scan),
               landmarksInView(simulation, event->scan, simulated->T_map_base * event->T_base_laser,
                               simulated->beam_landmarks),
               tables);
    if (wantsPoints(arguments, index)) tables.addPoints(index, event->scan);
  }
}

void runRecording(const Arguments& arguments, TimedDetector& detector, Tables& tables) {
  const core::AcfrRecording recording = core::readAcfr(arguments.recording);
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    recordScan(i, detector.detect(recording.scans[i]), {}, tables);
    if (wantsPoints(arguments, i)) tables.addPoints(i, recording.scans[i]);
  }
}

core::PerceptionConfig loadConfig(const std::vector<std::string>& files) {
  core::ConfigReport report;
  const core::SuiteConfig suite = core::loadSuiteConfig(files, report);
  for (const std::string& warning : report.warnings) {
    std::fprintf(stderr, "detector_statistics: %s\n", warning.c_str());
  }
  report.throwIfUnusable();
  return suite.cekf_slam.perception;
}

void declareOptions(CLI::App& app, Arguments& arguments) {
  auto* world = app.add_option("--world", arguments.world, "simulated world, for instance park");
  auto* recording =
      app.add_option("--recording", arguments.recording, "ACFR recording, as acfr_to_bag reads it");
  world->excludes(recording);
  app.add_option("--seed", arguments.seed, "of the simulation")->capture_default_str();
  app.add_option("--laps", arguments.laps, "of the simulated drive")->capture_default_str();
  app.add_option("--duration", arguments.duration_s, "of the simulated drive [s]; 0 for no limit")
      ->capture_default_str();
  app.add_option("--every", arguments.every, "takes one scan of so many")
      ->check(aboveZero())
      ->capture_default_str();
  app.add_option("--config", arguments.configs, "YAML files, applied in order over the defaults");
  app.add_option("--points", arguments.point_scans, "scans whose points are written, too");
  app.add_option("--output", arguments.output, "folder for the tables")->required();
}

int run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{
      "Runs the landmark detector over a simulated drive (against truth) or a recording "
      "and writes tables of what it saw."};
  declareOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  if (arguments.world.empty() && arguments.recording.empty()) {
    throw core::InputError("Give --world or --recording.");
  }
  TimedDetector detector(loadConfig(arguments.configs));
  Tables tables(arguments.output);
  if (arguments.world.empty()) {
    runRecording(arguments, detector, tables);
  } else {
    runWorld(arguments, detector, tables);
  }
  detector.print();
  return 0;
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  try {
    return hymm::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "detector_statistics: %s\n", error.what());
    return 1;
  }
}
