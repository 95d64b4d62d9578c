// A simulated drive with the filter and the dense map behind it, beside a plain global grid that is
// fed with the same scans at the same estimated poses. Prints, as JSON, how well both agree with
// the truth after each lap and around the largest correction; writes pictures of both (pgm).
//
//   map_closure WORLD LAPS SEED OUTPUT CONFIG_FOLDER CONFIG...

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "beam_outcomes.h"
#include "benchmark/flat_grid.h"
#include "cekf/map_schedule.h"
#include "free_cells.h"
#include "hybrid_map/log_odds.h"
#include "hybrid_map/map_export.h"
#include "hybrid_map/map_image.h"
#include "ltr_placement.h"
#include "pipeline/grid_files.h"
#include "pipeline/grid_mapper.h"
#include "pipeline/suite_config.h"
#include "simulation/simulation.h"

namespace hymm::core {
namespace {

constexpr double kResolution_m = 0.2;
constexpr const char* kLayer = "salinity";
constexpr double kReach_m = 60.0;    // around the true world, that the peer's array covers
constexpr double kPicture_m = 17.0;  // from the middle of the experiment's picture to its corners

struct Options {
  std::string world;
  int laps = 0;
  std::uint64_t seed = 0;
  std::string output;
  SuiteConfig config;
};

/// Whether cells are occupied, over the box of the true world.
struct Occupied {
  explicit Occupied(const TrueOccupancy& truth)
      : truth_(truth), corner_((truth.origin / truth.resolution_m).array().round().cast<int>()) {
    cells_.assign(truth.occupied.size(), false);
  }
  void set(int x, int y) {
    if (isInside(x, y)) cells_[index(x, y)] = true;
  }
  void setAt(const Eigen::Vector2d& place) {
    const Eigen::Array2d cell = (place / truth_.resolution_m).array().floor();
    set(static_cast<int>(cell.x()) - corner_.x(), static_cast<int>(cell.y()) - corner_.y());
  }
  bool at(int x, int y) const { return isInside(x, y) && cells_[index(x, y)]; }
  bool around(int x, int y) const {
    for (int j = y - 1; j <= y + 1; ++j) {
      for (int i = x - 1; i <= x + 1; ++i) {
        if (at(i, j)) return true;
      }
    }
    return false;
  }
  int width() const { return truth_.width; }
  int height() const { return truth_.height; }
  const Eigen::Vector2i& corner() const { return corner_; }

 private:
  bool isInside(int x, int y) const {
    return x >= 0 && y >= 0 && x < truth_.width && y < truth_.height;
  }
  std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(truth_.width) + std::size_t(x);
  }
  const TrueOccupancy& truth_;
  Eigen::Vector2i corner_;
  std::vector<bool> cells_;
};

/// Share of the cells of `some` that have one of `others` within one cell.
double shareNear(const Occupied& some, const Occupied& others) {
  int count = 0, near = 0;
  for (int y = 0; y < some.height(); ++y) {
    for (int x = 0; x < some.width(); ++x) {
      if (!some.at(x, y)) continue;
      ++count;
      near += others.around(x, y) ? 1 : 0;
    }
  }
  return count > 0 ? static_cast<double>(near) / count : 0.0;
}

class Drive {
 public:
  explicit Drive(const Options& options)
      : options_(options),
        simulation_(simulationOf(options), options.config.vehicle, options.seed),
        truth_(simulation_.occupancy(kResolution_m)),
        standing_(truth_),
        seen_(truth_),
        filter_(options.config.cekf_slam, options.config.vehicle),
        schedule_(options.config.cekf_slam),
        mapper_(options.config.hymm_grid),
        image_(MapImageConfig{}),
        flat_(truth_.origin.array() - kReach_m, highOf(truth_).array() + kReach_m, kResolution_m,
              options.config.hymm_grid.map.occupancy),
        truly_placed_(flat_),
        outcomes_(truth_) {
    for (int y = 0; y < truth_.height; ++y) {
      for (int x = 0; x < truth_.width; ++x) {
        const std::size_t i = std::size_t(y) * std::size_t(truth_.width) + std::size_t(x);
        if (truth_.occupied[i]) standing_.set(x, y);
      }
    }
  }

  /// Drives on to the next scan; false at the end.
  bool next() {
    while (auto simulated = simulation_.next()) {
      const auto outcome = filter_.process(simulated->event);
      if (!outcome || !outcome->accepted) continue;
      const auto* scan = std::get_if<ScanEvent>(&simulated->event);
      if (scan == nullptr) continue;
      take(*scan, *outcome, simulated->T_map_base);
      return true;
    }
    return false;
  }

  double correction_m() const { return correction_m_; }
  double time_s() const { return time_s_; }
  double progress() const { return simulation_.progress(); }

  /// A figure a line, as JSON: `"PREFIX_NAME": value,`.
  void report(const std::string& prefix) {
    image_.update(mapper_.map());
    const Occupied ours = occupiedOf(image_.image()), flat = occupiedOf(flat_.image());
    print(prefix + "_precision", shareNear(ours, standing_));
    print(prefix + "_recall", shareNear(seen_, ours));
    print(prefix + "_flat_precision", shareNear(flat, standing_));
    print(prefix + "_flat_recall", shareNear(seen_, flat));
    const Occupied truly_placed = occupiedOf(truly_placed_.image());
    print(prefix + "_true_pose_precision", shareNear(truly_placed, standing_));
    print(prefix + "_true_pose_recall", shareNear(seen_, truly_placed));
    print(prefix + "_position_error_m", position_error_m_);
    print(prefix + "_time_s", time_s_);
    print(prefix + "_ltrs", double(mapper_.map().partition().mesh().aliveCount()));
    reportProperty(prefix);
    const std::filesystem::path folder(options_.output);
    exportPgm(image_.image(), folder / (prefix + "_ltrs"));
    exportPgm(flat_.image(), folder / (prefix + "_flat"));
  }

  /// From here on the map's places are compared with those of now.
  void rememberPlaces() {
    const LandmarkMap map = filter_.landmarkMap(0.0);
    for (const auto& landmark : map.landmarks) places_before_[landmark.id] = landmark.position;
    sensor_path_.clear();
  }

  /// Where the map moved most of what no beam has reached since: the landmark farthest from where
  /// it was, of those around which all within `around_m` was out of range ever since. What is there
  /// now was not observed anew; it followed.
  void reportLargestShift(double around_m) {
    const double reach_m = options_.config.hymm_grid.map.occupancy.range_m + around_m;
    const LandmarkEstimate* farthest = nullptr;
    double largest_m = -1.0;
    const LandmarkMap map = filter_.landmarkMap(0.0);
    for (const LandmarkEstimate& landmark : map.landmarks) {
      const auto before = places_before_.find(landmark.id);
      if (before == places_before_.end()) continue;
      const double shift_m = (landmark.position - before->second).norm();
      if (shift_m <= largest_m || distanceToPath(landmark.position) <= reach_m) continue;
      largest_m = shift_m;
      farthest = &landmark;
    }
    if (farthest == nullptr) return;
    print("largest_shift_m", largest_m);
    print("largest_shift_x_m", farthest->position.x());
    print("largest_shift_y_m", farthest->position.y());
    print("largest_shift_nearest_scan_m", distanceToPath(farthest->position));
    std::cout << "  \"largest_shift_truth\": [";
    const char* separator = "";
    for (const TrueLandmark& landmark : simulation_.landmarks()) {
      if ((landmark.position - farthest->position).norm() > around_m) continue;
      std::cout << separator << '[' << landmark.position.x() << ", " << landmark.position.y()
                << ']';
      separator = ", ";
    }
    std::cout << "],\n";
  }

  /// Of what share of the beams that reached them those cells stopped that the map misses, and the
  /// others.
  void reportOutcomes() {
    const OccupancyConfig& occupancy = options_.config.hymm_grid.map.occupancy;
    const double hit = logOddsOf(occupancy.hit_probability);
    const double miss = -logOddsOf(occupancy.miss_probability);
    const Occupied ours = occupiedOf(image_.image());
    const auto compared = outcomes_.compare([&](int x, int y) { return ours.around(x, y); });
    std::cout << compared.text("end_cells", miss / (hit + miss));
  }

  /// How much of what the map calls free, at the end, is solid.
  void reportFree() {
    constexpr double kFine_m = 0.02;
    const TrueOccupancy fine = simulation_.occupancy(kFine_m);
    const FreeCells free(truth_, fine);
    std::cout << free.text("end", image_.image()) << free.text("end_flat", flat_.image())
              << free.text("end_true_pose", truly_placed_.image());
  }

  void reportPlacement() {
    std::cout << placement_.text("placed", filter_.landmarkMap(0.0), simulation_.landmarks());
  }

  void writeMemory() const { std::cerr << memory_.text(); }

 private:
  static SimulationConfig simulationOf(const Options& options) {
    SimulationConfig config;
    config.world.name = options.world;
    config.drive.laps = options.laps;
    return config;
  }
  static Eigen::Vector2d highOf(const TrueOccupancy& truth) {
    return truth.origin + truth.resolution_m * Eigen::Vector2d(truth.width, truth.height);
  }
  static void print(const std::string& name, double value) {
    std::cout << "  \"" << name << "\": " << value << ",\n";
  }

  /// From a place to where the sensor was since rememberPlaces(), at its nearest.
  double distanceToPath(const Eigen::Vector2d& place) const {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& at : sensor_path_) {
      nearest_m = std::min(nearest_m, (at - place).norm());
    }
    return nearest_m;
  }

  void take(const ScanEvent& scan, const ScanOutcome& outcome, const Pose2& T_map_base_true) {
    time_s_ = outcome.pose.time_s;
    correction_m_ = outcome.largest_correction_m;
    position_error_m_ = (outcome.pose.T_map_base.position() - T_map_base_true.position()).norm();
    MappedScan mapped;
    mapped.pose = outcome.pose;
    mapped.update = filter_.takeUpdate();
    mapped.scan = scan.scan;
    const bool corrected = filter_.counts().map_corrections > corrections_;
    corrections_ = filter_.counts().map_corrections;
    if (schedule_.isDue(time_s_, corrected)) {
      schedule_.note(time_s_);
      mapped.map = std::make_shared<const LandmarkMap>(
          filter_.landmarkMap(options_.config.cekf_slam.landmark_block_range_m));
    }
    const MappedOutcome mapping = mapper_.process(mapped);
    if (mapping.topology) filter_.pinLandmarks(time_s_, mapper_.map().pinnedLandmarks());
    if (mapping.written) {
      const PosedScan posed = mapper_.posed(scan.scan, outcome.pose);
      flat_.insert(posed.scan, posed.T_map_laser);
      sensor_path_.push_back(posed.T_map_laser.position());
      const Pose2 T_map_laser_true = T_map_base_true * scan.T_base_laser;
      truly_placed_.insert(posed.scan, T_map_laser_true);
      noteSeen(scan, T_map_laser_true);
      outcomes_.look(posed.scan, T_map_laser_true, options_.config.hymm_grid.map.occupancy.range_m,
                     static_cast<int>(simulation_.progress() * options_.laps));
      if (placement_due_.takeIfDue(time_s_)) {
        placement_.look(mapper_.map(), filter_, outcome.pose.T_map_base, T_map_base_true,
                        options_.config.hymm_grid.map.occupancy.range_m);
      }
    }
    if (memory_due_.takeIfDue(time_s_)) memory_.add(memoryOf(mapper_.map(), time_s_));
    if (simulation_.progress() * options_.laps > 0.7 && !sampled_) {
      sample(outcome.pose.T_map_base, T_map_base_true);
    }
  }

  /// What stands and was hit, so that a map can know it.
  void noteSeen(const ScanEvent& event, const Pose2& T_map_laser) {
    const LaserScan& scan = event.scan;
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const auto range = static_cast<double>(scan.ranges_m[i]);
      if (!(range >= scan.range_min_m &&
            range <= options_.config.hymm_grid.map.occupancy.range_m)) {
        continue;
      }
      const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
      const Eigen::Vector2d end =
          T_map_laser.position() + range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
      const Eigen::Array2i cell =
          (end / kResolution_m).array().floor().cast<int>() - standing_.corner().array();
      if (standing_.at(cell.x(), cell.y())) seen_.set(cell.x(), cell.y());
    }
  }

  Occupied occupiedOf(const OccupancyImage& image) const {
    Occupied occupied(truth_);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (trinaryOccupancy(image.at(x, y)) > 0) occupied.setAt(image.centre(x, y));
      }
    }
    return occupied;
  }

  /// A property of the ground 5 m ahead, measured from the vehicle.
  void sample(const Pose2& T_map_base, const Pose2& T_map_base_true) {
    const Eigen::Vector2d place = T_map_base * Eigen::Vector2d(5.0, 0.0);
    if (mapper_.map().partition().mesh().locate(place) == kNone) return;  // later, in an LTR
    sampled_ = T_map_base_true * Eigen::Vector2d(5.0, 0.0);
    PropertySample sample;
    sample.layer = kLayer;
    sample.position = place;
    sample.sample.value = 35.0;
    sample.sample.variance = 0.01;
    if (!mapper_.insert(sample).accepted) std::exit(1);
    sample_error_m_ = (sample.position - *sampled_).norm();
  }

  /// How far from its true place the property is found now.
  void reportProperty(const std::string& prefix) const {
    if (!sampled_) return;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (double x = -5.0; x <= 5.0; x += 0.05) {
      for (double y = -5.0; y <= 5.0; y += 0.05) {
        const Eigen::Vector2d off(x, y);
        if (off.norm() >= nearest_m) continue;
        const LayerQuery answer = mapper_.map().query(kLayer, *sampled_ + off);
        if (answer.value) nearest_m = off.norm();
      }
    }
    print(prefix + "_property_error_m", std::isfinite(nearest_m) ? nearest_m : -1.0);
    print(prefix + "_property_error_when_written_m", sample_error_m_);
  }

  const Options& options_;
  Simulation simulation_;
  TrueOccupancy truth_;
  Occupied standing_, seen_;
  CekfSlam filter_;
  MapSchedule schedule_;
  GridMapper mapper_;
  MapImage image_;
  benchmarks::FlatGrid flat_;
  benchmarks::FlatGrid truly_placed_;  ///< the same scans at the true poses
  BeamOutcomes outcomes_;
  std::unordered_map<int, Eigen::Vector2d> places_before_;  ///< the closure, by landmark
  std::vector<Eigen::Vector2d> sensor_path_;  ///< since then, where scans were written
  MapMemoryLog memory_;
  StampSchedule memory_due_{kMemoryLogPeriod_s};
  LtrPlacement placement_;
  StampSchedule placement_due_{1.0};
  std::size_t corrections_ = 0;
  double time_s_ = 0.0, correction_m_ = 0.0, position_error_m_ = 0.0, sample_error_m_ = 0.0;
  std::optional<Eigen::Vector2d> sampled_;  ///< its true place
};

/// When the largest correction comes.
double closureTime(const Options& options) {
  Drive drive(options);
  double largest_m = 0.0, time_s = 0.0;
  while (drive.next()) {
    if (drive.correction_m() <= largest_m) continue;
    largest_m = drive.correction_m();
    time_s = drive.time_s();
  }
  std::cout << "  \"largest_correction_m\": " << largest_m << ",\n";
  return time_s;
}

void run(const Options& options) {
  constexpr double kSettled_s = 10.0;  // the correction comes in several steps
  const double closure_s = closureTime(options);
  Drive drive(options);
  int laps = 0;
  bool before = false, after = false;
  while (drive.next()) {
    if (!before && drive.time_s() > closure_s - 1.0) {
      drive.report("before");
      drive.rememberPlaces();
      before = true;
    } else if (!after && drive.time_s() > closure_s + kSettled_s) {
      drive.report("after");
      drive.reportLargestShift(kPicture_m);
      after = true;
    }
    if (drive.progress() * options.laps >= laps + 1) drive.report("lap_" + std::to_string(++laps));
  }
  drive.report("end");
  drive.reportOutcomes();
  drive.reportFree();
  drive.reportPlacement();
  drive.writeMemory();
}

Options parsed(int argc, char** argv) {
  if (argc < 6)
    throw std::runtime_error("usage: map_closure WORLD LAPS SEED OUTPUT CONFIG_FOLDER CONFIG...");
  Options options;
  options.world = argv[1];
  options.laps = std::atoi(argv[2]);
  options.seed = static_cast<std::uint64_t>(std::atoi(argv[3]));
  options.output = argv[4];
  const std::string folder = argv[5];
  ConfigReport report;
  options.config = loadSuiteConfig(std::vector<std::string>(argv + 6, argv + argc), report,
                                   [folder] { return folder; });
  report.throwIfUnusable();
  options.config.hymm_grid.map.resolution_m = kResolution_m;
  options.config.hymm_grid.map.layers = std::string(kLayer) + " gaussian";
  return options;
}

}  // namespace
}  // namespace hymm::core

int main(int argc, char** argv) {
  try {
    const hymm::core::Options options = hymm::core::parsed(argc, argv);
    std::cout << "{\n";
    hymm::core::run(options);
    std::cout << "  \"seed\": " << options.seed << "\n}\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "map_closure: " << error.what() << '\n';
    return 1;
  }
}
