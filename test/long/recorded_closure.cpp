// A recording of ACFR's car through the filter with the dense map behind it, beside a plain global
// grid that is fed with the same scans at the same estimated poses. Prints, as JSON, the largest
// correction of the map, what the map takes in each form of compression and how fast it is made;
// writes pictures of both maps (pgm) before and after that correction and at the end, and where
// beams ended that met a rise of the ground in Victoria Park (rise.csv), and how many cells of it
// are occupied in either map from a minute before that correction on (rise_cells.csv).
//
//   recorded_closure RECORDING OUTPUT CONFIG_FOLDER CONFIG...

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/acfr_recording.h"
#include "hybrid_map/map_export.h"
#include "hybrid_map/map_image.h"
#include "long/mapping_drive.h"
#include "pipeline/sensor_merger.h"

namespace hymm::core {
namespace {

// Victoria Park's drive stays within these of its start.
const Eigen::Vector2d kLow(-350.0, -350.0), kHigh(350.0, 350.0);

// Around a line that looks like a fence there, and swings from scan to scan.
const Eigen::Vector2d kRiseLow(14.0, 188.0), kRiseHigh(34.0, 212.0);

struct Options {
  std::string recording, output;
  SuiteConfig config;
};

std::vector<SensorEvent> eventsOf(const AcfrRecording& recording, const SuiteConfig& config) {
  SensorMerger merger(config.cekf_slam.merger);
  std::vector<SensorEvent> events;
  const auto take = [&](const std::vector<SensorEvent>& released) {
    events.insert(events.end(), released.begin(), released.end());
  };
  for (const AcfrRecording::Event& event : recording.events) {
    if (event.sensor == AcfrSensor::kMotion) {
      merger.push(MotionInput(recording.motion[event.index]));
    } else if (event.sensor == AcfrSensor::kLaser) {
      merger.push(ScanEvent{recording.scans[event.index], config.vehicle.laser.T_base_sensor()});
    }
    take(merger.popReady());
  }
  take(merger.flush());
  return events;
}

void print(const std::string& name, double value) {
  std::cout << "  \"" << name << "\": " << value << ",\n";
}

struct Closure {
  double time_s = 0.0, correction_m = 0.0;
};

/// The largest correction that moved landmarks, and how fast filter and map together are.
Closure findClosure(const Options& options, const std::vector<SensorEvent>& events) {
  test::MappingDrive drive(options.config, kLow, kHigh);
  Closure closure;
  for (const SensorEvent& event : events) {
    const auto step = drive.process(event);
    if (!step || step->outcome.largest_correction_m <= closure.correction_m) continue;
    closure = {step->outcome.pose.time_s, step->outcome.largest_correction_m};
  }
  return closure;
}

void writeImages(const test::MappingDrive& drive, const std::string& stage,
                 const std::filesystem::path& folder) {
  MapImage image{MapImageConfig()};
  image.update(drive.mapper().map());
  exportPgm(image.image(), folder / (stage + "_ltrs"));
  exportPgm(drive.flat().image(), folder / (stage + "_flat"));
}

void writeEnds(const PosedScan& posed, double range_m, std::ostream& file) {
  for (std::size_t i = 0; i < posed.scan.ranges_m.size(); ++i) {
    const auto range = static_cast<double>(posed.scan.ranges_m[i]);
    if (!posed.scan.isHit(range) || range > range_m) continue;
    const double bearing = posed.scan.bearing(i);
    const Eigen::Vector2d end = posed.scan.poseAtBeam(i, posed.T_map_laser) *
                                (range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
    const bool is_there =
        (end.array() > kRiseLow.array()).all() && (end.array() < kRiseHigh.array()).all();
    if (is_there) file << posed.scan.time_s << ',' << end.x() << ',' << end.y() << '\n';
  }
}

/// Occupied cells around the rise, as map_server would take them.
int occupiedAtRise(const OccupancyImage& image) {
  const Eigen::Array2d size(image.width, image.height);
  const auto cellOf = [&](const Eigen::Vector2d& place) {
    const Eigen::Array2d cell = ((place - image.origin()) / image.resolution_m).array().floor();
    return Eigen::Array2i(cell.max(0.0).min(size).cast<int>());
  };
  const Eigen::Array2i low = cellOf(kRiseLow), high = cellOf(kRiseHigh);
  int count = 0;
  for (int y = low.y(); y < high.y(); ++y) {
    for (int x = low.x(); x < high.x(); ++x) count += trinaryOccupancy(image.at(x, y)) > 0 ? 1 : 0;
  }
  return count;
}

/// Writes that, now and then.
class RiseLog {
 public:
  RiseLog(const std::filesystem::path& file, double from_s) : file_(file), from_s_(from_s) {
    file_ << std::fixed << "t,ltrs,flat\n";
  }

  void note(const test::MappingDrive& drive, double time_s) {
    if (time_s < from_s_ || !due_.takeIfDue(time_s)) return;
    image_.update(drive.mapper().map());
    file_ << time_s << ',' << occupiedAtRise(image_.image()) << ','
          << occupiedAtRise(drive.flat().image()) << '\n';
  }

 private:
  static constexpr double kPeriod_s = 4.0;

  std::ofstream file_;
  double from_s_;
  StampSchedule due_{kPeriod_s};
  MapImage image_{MapImageConfig()};
};

void run(const Options& options) {
  constexpr double kSettled_s = 10.0;  // the correction comes in several steps
  constexpr double kAhead_s = 60.0;
  const std::vector<SensorEvent> events = eventsOf(readAcfr({options.recording}), options.config);
  const Closure closure = findClosure(options, events);
  print("largest_correction_m", closure.correction_m);
  print("closure_s", closure.time_s - timeOf(events.front()));

  test::MappingDrive drive(options.config, kLow, kHigh);
  std::ofstream ends(std::filesystem::path(options.output) / "rise.csv");
  ends << std::fixed << "t,x,y\n";
  RiseLog rise(std::filesystem::path(options.output) / "rise_cells.csv", closure.time_s - kAhead_s);
  bool before = false, after = false;
  for (const SensorEvent& event : events) {
    const auto step = drive.process(event);
    if (!step) continue;
    if (step->written) {
      writeEnds(*step->written, options.config.hymm_grid.map.occupancy.range_m, ends);
    }
    rise.note(drive, step->outcome.pose.time_s);
    const Pose2& pose = step->outcome.pose.T_map_base;
    if (!before && step->outcome.pose.time_s > closure.time_s - 1.0) {
      before = true;
      print("closure_x_m", pose.x_m);
      print("closure_y_m", pose.y_m);
      writeImages(drive, "before", options.output);
    } else if (!after && step->outcome.pose.time_s > closure.time_s + kSettled_s) {
      after = true;
      writeImages(drive, "after", options.output);
    }
  }
  writeImages(drive, "end", options.output);
  const test::CompressionFigures figures = test::compressionOf(
      drive.mapper().map(), options.config.hymm_grid.map.compression.occupied_probability);
  print("occupancy_mb", figures.raw_mb);
  print("lossless_ratio", figures.raw_mb / figures.lossless_mb);
  print("lossy_ratio", figures.raw_mb / figures.lossy_mb);
  print("lossy_probability_rms", figures.probability_rms);
  print("lossy_changed_share", figures.changed_share);
  print("lossy_changed_occupied_share", figures.changed_occupied_share);
  print("ltrs", static_cast<double>(drive.mapper().map().partition().mesh().aliveCount()));
  print("map_cpu_s", drive.mapper().cpu_s());
  std::cerr << drive.memoryText();
}

Options parsed(int argc, char** argv) {
  if (argc < 5) {
    throw std::runtime_error("usage: recorded_closure RECORDING OUTPUT CONFIG_FOLDER CONFIG...");
  }
  Options options;
  options.recording = argv[1];
  options.output = argv[2];
  const std::string folder = argv[3];
  ConfigReport report;
  options.config = loadSuiteConfig(std::vector<std::string>(argv + 4, argv + argc), report,
                                   [folder] { return folder; });
  report.throwIfUnusable();
  return options;
}

}  // namespace
}  // namespace hymm::core

int main(int argc, char** argv) {
  try {
    const hymm::core::Options options = hymm::core::parsed(argc, argv);
    std::cout << "{\n";
    hymm::core::run(options);
    std::cout << "  \"recording\": \"" << options.recording << "\"\n}\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "recorded_closure: " << error.what() << '\n';
    return 1;
  }
}
