// Level sets after a change of the map: the incremental search, a quadtree from scratch, and a
// full uniform grid, over the same versions of the map of a simulated park.

#include <memory>
#include <vector>

#include "benchmark/benchmarks.h"
#include "cekf/cekf_slam.h"
#include "information_map/full_evaluation.h"
#include "information_map/level_set_search.h"
#include "simulation/simulation.h"

namespace hymm::benchmarks {
namespace {

constexpr int kChanges = 200;
constexpr double kPeriod_s = 1.0;

struct MapVersion {
  std::shared_ptr<const core::LandmarkField> field;
  Eigen::Vector2d vehicle;
};

/// Versions of the map, one a second, of a drive of two laps through a park.
const std::vector<MapVersion>& mapVersions() {
  static const std::vector<MapVersion> versions = [] {
    core::SimulationConfig world;
    world.world.name = "park";
    world.drive.laps = 3;
    world.laser.enabled = false;
    world.gps.enabled = false;
    world.detections.enabled = true;
    core::CekfSlamConfig filter;
    filter.observation_input = "detections";
    core::Simulation simulation(world, core::simulatedCar(), 1);
    core::CekfSlam slam(filter, core::simulatedCar());
    const double range_m = core::InformationMapConfig{}.information.sensor.range_m;
    std::vector<MapVersion> made;
    double next_s = 0.0;
    while (const auto simulated = simulation.next()) {
      const auto outcome = slam.process(simulated->event);
      if (!outcome || slam.landmarkCount() == 0 || outcome->pose.time_s < next_s) continue;
      next_s = outcome->pose.time_s + kPeriod_s;
      made.push_back({std::make_shared<const core::LandmarkField>(
                          slam.landmarkMap(filter.landmark_block_range_m), range_m),
                      outcome->pose.T_map_base.position()});
      if (made.size() == kChanges) break;
    }
    return made;
  }();
  return versions;
}

/// One iteration updates the sets after one change of the map.
void incremental(benchmark::State& state) {
  const auto& versions = mapVersions();
  auto search = std::make_unique<core::LevelSetSearch>(core::InformationMapConfig{});
  std::size_t next = 0, evaluations = 0;
  for (auto _ : state) {
    if (next == versions.size()) {
      state.PauseTiming();
      search = std::make_unique<core::LevelSetSearch>(core::InformationMapConfig{});
      next = 0;
      state.ResumeTiming();
    }
    evaluations += search->update(versions[next].field, versions[next].vehicle).evaluations;
    ++next;
  }
  state.counters["evaluations"] =
      benchmark::Counter(static_cast<double>(evaluations), benchmark::Counter::kAvgIterations);
}

template <class Evaluate>
void fromNothing(benchmark::State& state, Evaluate&& evaluate) {
  const auto& versions = mapVersions();
  std::size_t next = 0, evaluations = 0;
  for (auto _ : state) {
    evaluations += evaluate(versions[next]);
    next = (next + 1) % versions.size();
  }
  state.counters["evaluations"] =
      benchmark::Counter(static_cast<double>(evaluations), benchmark::Counter::kAvgIterations);
}

std::size_t evaluateScratch(const MapVersion& version) {
  core::InformationMapConfig config;
  config.level_sets.max_evaluations = 1000000000;
  core::LevelSetSearch search(config);
  return search.update(version.field, version.vehicle).evaluations;
}

std::size_t evaluateFull(const MapVersion& version) {
  return core::evaluateFully(core::InformationMapConfig{}, *version.field).evaluations;
}

}  // namespace

void registerLevelSetBenchmarks(Registration& registration) {
  // Whole drives, so that each benchmark meets the same versions of the map.
  const auto whole_drives = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMillisecond)->Iterations(kChanges);
  };
  registration.add("BM_LevelSetIncremental", incremental, whole_drives);
  registration.add(
      "BM_LevelSetFull", [](benchmark::State& state) { fromNothing(state, evaluateFull); },
      whole_drives);
  registration.add(
      "BM_LevelSetScratch", [](benchmark::State& state) { fromNothing(state, evaluateScratch); },
      whole_drives);
}

}  // namespace hymm::benchmarks
