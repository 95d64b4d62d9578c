// Rays per second into the occupancy layer of the hybrid map, into an OctoMap, and into one flat
// array: the same scans of the same drive, from the same poses.

#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include <octomap/OcTree.h>

#include "benchmark/benchmarks.h"
#include "benchmark/flat_grid.h"
#include "benchmark/trunk_map.h"
#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/written_beam.h"
#include "simulation/simulation.h"

namespace hymm::benchmarks {
namespace {

using core::PosedScan;

constexpr double kDuration_s = 100.0;
constexpr double kResolution_m = 0.2;
constexpr double kReach_m = 40.0;     // around the poses
constexpr double kAllOfIt_m = 500.0;  // nothing is packed: the peers do not pack either

/// Scans of a drive through `park` with true poses, and the true landmarks.
struct Drive {
  std::vector<PosedScan> scans;
  core::LandmarkMap landmarks;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = Eigen::Vector2d::Constant(-1e9);
};

Drive makeDrive() {
  core::SimulationConfig config;
  config.drive.duration_s = kDuration_s;
  core::Simulation simulation(config, core::simulatedCar(), 1);
  Drive drive;
  std::vector<Eigen::Vector2d> places;
  for (const auto& landmark : simulation.landmarks()) places.push_back(landmark.position);
  drive.landmarks = certainLandmarks(places);
  while (auto simulated = simulation.next()) {
    const auto* event = std::get_if<core::ScanEvent>(&simulated->event);
    if (event == nullptr) continue;
    PosedScan posed;
    posed.scan = event->scan;
    posed.T_map_laser = simulated->T_map_base * event->T_base_laser;
    posed.map_version = drive.landmarks.version;
    drive.low = drive.low.cwiseMin(posed.T_map_laser.position());
    drive.high = drive.high.cwiseMax(posed.T_map_laser.position());
    drive.scans.push_back(posed);
  }
  drive.low.array() -= kReach_m;
  drive.high.array() += kReach_m;
  return drive;
}

const Drive& theDrive() {
  static const Drive drive = makeDrive();
  return drive;
}

void report(benchmark::State& state, std::size_t rays) {
  state.SetItemsProcessed(static_cast<std::int64_t>(rays));
  state.counters["scans"] = static_cast<double>(theDrive().scans.size());
}

void intoLtrs(benchmark::State& state) {
  const Drive& drive = theDrive();
  core::HybridMapConfig config;
  config.resolution_m = kResolution_m;
  config.active_radius_m = kAllOfIt_m;
  core::HybridMap map(config);
  map.apply(drive.landmarks);
  for (const PosedScan& posed : drive.scans) map.insert(posed);  // all cells have their memory
  const std::size_t before = map.counts().beams;
  for (auto _ : state) {
    for (const PosedScan& posed : drive.scans) map.insert(posed);
  }
  report(state, map.counts().beams - before);
  state.counters["ltrs"] = static_cast<double>(map.partition().mesh().aliveCount());
}

void intoFlatGrid(benchmark::State& state) {
  const Drive& drive = theDrive();
  FlatGrid grid(drive.low, drive.high, kResolution_m, {});
  for (const PosedScan& posed : drive.scans) grid.insert(posed.scan, posed.T_map_laser);
  std::size_t rays = 0;
  for (auto _ : state) {
    for (const PosedScan& posed : drive.scans) rays += grid.insert(posed.scan, posed.T_map_laser);
  }
  report(state, rays);
}

/// Ray by ray, inner nodes once a scan: of OctoMap's ways to insert a scan the fastest here (a
/// scan as a point cloud, with and without discretisation, keeps a set of keys that costs more).
std::size_t insert(const PosedScan& posed, const core::OccupancyConfig& config,
                   octomap::OcTree& tree) {
  std::size_t rays = 0;
  const core::Pose2& pose = posed.T_map_laser;
  const octomap::point3d origin(static_cast<float>(pose.x_m), static_cast<float>(pose.y_m), 0.1F);
  for (std::size_t i = 0; i < posed.scan.ranges_m.size(); ++i) {
    const std::optional<core::WrittenBeam> written = core::writtenBeam(posed.scan, i, config);
    if (!written) continue;
    const double length = written->length_m;
    const double bearing = pose.yaw_rad + posed.scan.bearing(i);
    const octomap::point3d end(static_cast<float>(pose.x_m + length * std::cos(bearing)),
                               static_cast<float>(pose.y_m + length * std::sin(bearing)), 0.1F);
    if (written->is_hit) {
      tree.insertRay(origin, end, -1.0, true);
    } else {
      octomap::KeyRay free;
      tree.computeRayKeys(origin, end, free);
      for (const octomap::OcTreeKey& key : free) tree.updateNode(key, false, true);
    }
    ++rays;
  }
  return rays;
}

void intoOctoMap(benchmark::State& state) {
  const Drive& drive = theDrive();
  const core::OccupancyConfig config;
  octomap::OcTree tree(kResolution_m);
  tree.setProbHit(config.hit_probability);
  tree.setProbMiss(config.miss_probability);
  tree.setClampingThresMin(config.min_probability);
  tree.setClampingThresMax(config.max_probability);
  for (const PosedScan& posed : drive.scans) insert(posed, config, tree);
  std::size_t rays = 0;
  for (auto _ : state) {
    for (const PosedScan& posed : drive.scans) rays += insert(posed, config, tree);
    tree.updateInnerOccupancy();
  }
  report(state, rays);
}

}  // namespace

void registerRayInsertionBenchmarks(Registration& registration) {
  const auto in_milliseconds = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMillisecond);
  };
  registration.add("BM_RayInsertionLtr", intoLtrs, in_milliseconds);
  registration.add("BM_RayInsertionOctoMap", intoOctoMap, in_milliseconds);
  registration.add("BM_RayInsertionFlatGrid", intoFlatGrid, in_milliseconds);
}

}  // namespace hymm::benchmarks
