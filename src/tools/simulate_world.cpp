#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <rosbag/bag.h>

#include "common/config.h"
#include "common/error.h"
#include "common/progress_bar.h"
#include "simulation/simulation.h"
#include "simulation/world_catalog.h"
#include "tools/above_zero.h"
#include "tools/bag_output.h"
#include "tools/simulation_bag_writer.h"

namespace hymm {
namespace {

struct Arguments {
  bool list = false;
  bool parameters = false;
  std::optional<std::string> world;
  std::optional<int> landmarks;
  std::optional<int> laps;
  std::optional<double> duration_s;
  std::optional<std::string> motion;
  bool detections = false;
  std::uint64_t seed = 1;
  std::string vehicle;
  std::string config;
  std::string output;
  std::string compression = "lz4";
  double map_resolution_m = 0.2;
};

void declareOptions(CLI::App& app, Arguments& arguments) {
  app.add_flag("--list", arguments.list, "names the worlds and ends");
  app.add_flag("--parameters", arguments.parameters, "names what --config can set and ends");
  app.add_option("--world", arguments.world, "which world (see --list); default park");
  app.add_option("--landmarks", arguments.landmarks, "how many; default: the world's own number")
      ->check(aboveZero());
  app.add_option("--laps", arguments.laps, "rounds of the route; default 3")->check(aboveZero());
  app.add_option("--duration", arguments.duration_s, "end the drive after so many seconds")
      ->check(aboveZero());
  app.add_option("--seed", arguments.seed, "same seed, same bytes")->capture_default_str();
  app.add_option("--vehicle", arguments.vehicle,
                 "YAML with the group 'vehicle': mountings, wheelbase, noise;"
                 " default: what config/vehicles/simulated_car.yaml says");
  app.add_option("--motion", arguments.motion,
                 "dead_reckoning (speed and steering, the default) or odom (twist)")
      ->check(CLI::IsMember({"dead_reckoning", "odom"}));
  app.add_flag("--detections", arguments.detections,
               "publish ranges and bearings of landmarks on detections, in place of scan");
  app.add_option("--config", arguments.config,
                 "YAML with the group 'simulation' (see --parameters)");
  app.add_option("--compression", arguments.compression, "of the bag: none, lz4 or bz2")
      ->check(CLI::IsMember({"none", "lz4", "bz2"}))
      ->capture_default_str();
  app.add_option("--map-resolution", arguments.map_resolution_m, "of /truth/map [m]")
      ->check(aboveZero())
      ->capture_default_str();
  app.add_option("--output", arguments.output, "bag to write; written as OUTPUT.active until done");
}

void listWorlds() {
  for (const core::WorldKind& kind : core::worldCatalog()) {
    std::printf("%-10s %s\n", kind.name.c_str(), kind.description.c_str());
  }
}

void listParameters() {
  core::SimulationConfig config;
  core::ConfigSchema schema;
  config.describe(schema);
  for (const auto& entry : schema.entries()) {
    std::printf("simulation.%-38s %s\n", entry.path.c_str(), entry.meaning.c_str());
  }
}

/// Reads the group `name` of a YAML file into `config`.
template <class Config>
void readGroup(const std::string& file, const std::string& name, Config& config) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(file);
  } catch (const YAML::Exception& error) {
    throw core::InputError(file + " cannot be read as YAML: " + error.what());
  }
  if (!root.IsMap() || !root[name]) {
    throw core::InputError(file + " has no group '" + name + "'; nothing in it can be used.");
  }
  core::ConfigReport report;
  core::readConfig(root[name], config, file + ": " + name, report);
  for (const std::string& warning : report.warnings) {
    std::fprintf(stderr, "simulate_world: %s\n", warning.c_str());
  }
  report.throwIfUnusable();
}

core::SimulationConfig configFrom(const Arguments& arguments) {
  core::SimulationConfig config;
  if (!arguments.config.empty()) readGroup(arguments.config, "simulation", config);
  config.world.name = arguments.world.value_or(config.world.name);
  config.world.landmarks = arguments.landmarks.value_or(config.world.landmarks);
  config.drive.laps = arguments.laps.value_or(config.drive.laps);
  config.drive.duration_s = arguments.duration_s.value_or(config.drive.duration_s);
  config.motion.output = arguments.motion.value_or(config.motion.output);
  if (arguments.detections) {
    config.detections.enabled = true;
    config.laser.enabled = false;
  }
  return config;
}

core::VehicleConfig vehicleFrom(const Arguments& arguments) {
  if (arguments.vehicle.empty()) return core::simulatedCar();
  core::VehicleConfig vehicle;
  readGroup(arguments.vehicle, "vehicle", vehicle);
  return vehicle;
}

rosbag::CompressionType compressionOf(const std::string& name) {
  static const std::map<std::string, rosbag::CompressionType> types = {
      {"none", rosbag::compression::Uncompressed},
      {"lz4", rosbag::compression::LZ4},
      {"bz2", rosbag::compression::BZ2}};
  return types.at(name);
}

/// What the bag holds, for the summary.
struct Counts {
  std::size_t motion = 0, scans = 0, detections = 0, fixes = 0;
  double last_s = 0.0, driven_m = 0.0;
  core::Pose2 T_map_base;

  void add(const core::SimulatedEvent& simulated) {
    motion += std::holds_alternative<core::MotionInput>(simulated.event) ? 1 : 0;
    scans += std::holds_alternative<core::ScanEvent>(simulated.event) ? 1 : 0;
    detections += std::holds_alternative<core::ObservationSet>(simulated.event) ? 1 : 0;
    fixes += std::holds_alternative<core::GpsFix>(simulated.event) ? 1 : 0;
    last_s = core::timeOf(simulated.event);
    driven_m += (simulated.T_map_base.position() - T_map_base.position()).norm();
    T_map_base = simulated.T_map_base;
  }
};

Counts writeEvents(core::Simulation& simulation, SimulationBagWriter& writer) {
  constexpr double kSteps = 1000.0;
  core::ProgressBar progress("Simulating", static_cast<std::size_t>(kSteps));
  Counts counts;
  while (const auto simulated = simulation.next()) {
    writer.write(*simulated);
    counts.add(*simulated);
    progress.update(static_cast<std::size_t>(kSteps * simulation.progress()));
  }
  return counts;
}

Counts writeBag(core::Simulation& simulation, const core::SimulationConfig& config,
                const core::VehicleConfig& vehicle, const Arguments& arguments) try {
  BagOutput output(arguments.output);
  output.bag().setCompression(compressionOf(arguments.compression));
  SimulationBagWriter writer(output.bag(), config, vehicle, simulation.terrain());
  const double start_s = core::Simulation::kStartTime_s;
  writer.writeMountings(start_s);
  if (config.gps.enabled) writer.writeGpsOrigin(start_s);
  writer.writeLandmarks(simulation.landmarks(), start_s);
  writer.writeOccupancy(simulation.occupancy(arguments.map_resolution_m), start_s);
  const Counts counts = writeEvents(simulation, writer);
  output.complete();
  return counts;
} catch (const rosbag::BagException& error) {
  throw writingFailed(arguments.output, error);
}

void run(const Arguments& arguments) {
  if (arguments.list) return listWorlds();
  if (arguments.parameters) return listParameters();
  if (arguments.output.empty()) throw core::InputError("--output is missing: which bag to write?");
  const core::SimulationConfig config = configFrom(arguments);
  const core::VehicleConfig vehicle = vehicleFrom(arguments);
  core::Simulation simulation(config, vehicle, arguments.seed);
  const Counts counts = writeBag(simulation, config, vehicle, arguments);
  std::printf("%s: world %s, seed %llu, vehicle %s\n", arguments.output.c_str(),
              config.world.name.c_str(), static_cast<unsigned long long>(arguments.seed),
              vehicle.name.c_str());
  std::printf("  %zu scans, %zu detection sets, %zu motion inputs, %zu GPS fixes\n", counts.scans,
              counts.detections, counts.motion, counts.fixes);
  std::printf("  %.1f s, %.0f m driven, %zu landmarks\n",
              counts.last_s - core::Simulation::kStartTime_s, counts.driven_m,
              simulation.landmarks().size());
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  CLI::App app(
      "Drives a simulated vehicle through a simulated world and writes what its sensors say, and "
      "the truth, to a bag.");
  hymm::Arguments arguments;
  hymm::declareOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    hymm::run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "simulate_world: %s\n", error.what());
    return 1;
  }
  return 0;
}
