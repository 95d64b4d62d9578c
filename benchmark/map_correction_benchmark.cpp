// What a correction of the landmarks costs the dense map: the hybrid map, whose LTRs move with
// their landmarks, and a flat grid, into which every scan is rasterised anew.

#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "benchmark/benchmarks.h"
#include "benchmark/flat_grid.h"
#include "benchmark/trunk_map.h"
#include "common/random.h"
#include "hybrid_map/hybrid_map.h"
#include "simulation/simulation.h"

namespace hymm::benchmarks {
namespace {

constexpr double kSpacing_m = 12.0;
constexpr int kScansPerLtr = 30;  // Victoria Park's recording: 7230 scans, 195 LTRs
constexpr double kResolution_m = 0.2;
constexpr const char* kLayer = "salinity";

struct Size {
  int columns, rows;  ///< of squares, each of which is two LTRs
  int ltrs() const { return 2 * columns * rows; }
};
constexpr int kMostToRerasterise = 1000;  // LTRs; ten times as many take a minute
constexpr Size kSizes[] = {{10, 5}, {25, 20}, {100, 50}};

std::vector<Eigen::Vector2d> placesOf(const Size& size, core::RandomGenerator& generator) {
  std::vector<Eigen::Vector2d> places;
  for (int row = 0; row <= size.rows; ++row) {
    for (int column = 0; column <= size.columns; ++column) {
      places.emplace_back(kSpacing_m * column + core::sampleUniform(generator, -1.0, 1.0),
                          kSpacing_m * row + core::sampleUniform(generator, -1.0, 1.0));
    }
  }
  return places;
}

/// Everything bends to the left and back, as when a long loop closes: by metres where it is far.
std::vector<core::LandmarkEstimate> bent(std::vector<core::LandmarkEstimate> landmarks) {
  for (core::LandmarkEstimate& landmark : landmarks) {
    landmark.position.y() += 1e-5 * landmark.position.x() * landmark.position.x() + 0.3;
  }
  return landmarks;
}

/// Between the landmarks that the last LTRs share.
Eigen::Vector2d sampledPlace(const std::vector<core::LandmarkEstimate>& landmarks) {
  return landmarks.back().position - Eigen::Vector2d(0.4, 0.5) * kSpacing_m;
}

void correctMap(benchmark::State& state, const Size& size) {
  core::RandomGenerator generator(1);
  const core::LandmarkMap landmarks = certainLandmarks(placesOf(size, generator));
  core::HybridMapConfig config;
  config.layers = std::string(kLayer) + " gaussian";
  config.resolution_m = kResolution_m;
  core::HybridMap map(config);
  map.apply(landmarks);
  core::PropertySample sample;
  sample.layer = kLayer;
  sample.position = sampledPlace(landmarks.landmarks);
  sample.sample.value = 35.0;
  sample.sample.variance = 0.01;
  if (!map.insert(sample).accepted) throw std::runtime_error("the sample was refused");

  core::LandmarkUpdate updates[2];
  updates[0].changed = bent(landmarks.landmarks);
  updates[1].changed = landmarks.landmarks;
  // The sample's place moves with the LTR; by (3), with the shares of its vertices.
  const int ltr = map.query(kLayer, sample.position).ltr;
  const auto local = map.partition().mesh().ltr(ltr).triangle.toLocal(sample.position);
  Eigen::Vector2d places[2];
  for (int i = 0; i < 2; ++i) {
    updates[i].since_version = static_cast<std::uint64_t>(i) + 1;
    updates[i].version = updates[i].since_version + 1;
    const core::MapOutcome outcome = map.apply(updates[i]);
    if (!outcome.accepted || !outcome.change.retired.empty()) {
      throw std::runtime_error("the correction was to keep all LTRs: " + outcome.reason);
    }
    places[i] = map.partition().mesh().ltr(ltr).triangle.toGlobal(local);
  }
  std::uint64_t version = 3;
  std::size_t found = 0, iterations = 0;
  for (auto _ : state) {
    const std::size_t which = iterations++ % 2;
    updates[which].since_version = version;
    updates[which].version = ++version;
    const core::MapOutcome outcome = map.apply(updates[which]);
    const core::LayerQuery answer = map.query(kLayer, places[which]);
    if (outcome.accepted && answer.value && std::abs(answer.value->value - 35.0) < 1e-3) ++found;
  }
  if (found != iterations || places[0] == places[1])
    state.SkipWithError("a query did not find the moved value");
  state.counters["ltrs"] = static_cast<double>(map.partition().mesh().aliveCount());
}

/// Scans as the car park gives them.
std::vector<core::LaserScan> someScans() {
  core::SimulationConfig config;
  config.drive.duration_s = 60.0;
  core::Simulation simulation(config, core::simulatedCar(), 1);
  std::vector<core::LaserScan> scans;
  while (auto simulated = simulation.next()) {
    const auto* event = std::get_if<core::ScanEvent>(&simulated->event);
    if (event != nullptr) scans.push_back(event->scan);
  }
  return scans;
}

void rerasterise(benchmark::State& state, const Size& size) {
  core::RandomGenerator generator(1);
  const std::vector<core::LaserScan> scans = someScans();
  const Eigen::Vector2d low = Eigen::Vector2d::Constant(-40.0);
  const Eigen::Vector2d end = kSpacing_m * Eigen::Vector2d(size.columns, size.rows);
  FlatGrid grid(low, end - low, kResolution_m, {});
  std::vector<core::Pose2> poses;
  for (int i = 0; i < kScansPerLtr * size.ltrs(); ++i) {
    poses.push_back({core::sampleUniform(generator, 0.0, end.x()),
                     core::sampleUniform(generator, 0.0, end.y()),
                     core::sampleUniform(generator, -3.0, 3.0)});
  }
  for (auto _ : state) {
    grid.clear();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      grid.insert(scans[i % scans.size()], poses[i]);
    }
  }
  state.counters["scans"] = static_cast<double>(poses.size());
}

}  // namespace

void registerMapCorrectionBenchmarks(Registration& registration) {
  for (const Size& size : kSizes) {
    registration.add(
        "BM_MapCorrection/" + std::to_string(size.ltrs()),
        [size](benchmark::State& state) { correctMap(state, size); },
        [](benchmark::internal::Benchmark* benchmark) {
          benchmark->Unit(benchmark::kMicrosecond);
        });
  }
  for (const Size& size : kSizes) {
    if (size.ltrs() > kMostToRerasterise) continue;
    registration.add(
        "BM_Rerasterise/" + std::to_string(size.ltrs()),
        [size](benchmark::State& state) { rerasterise(state, size); },
        [](benchmark::internal::Benchmark* benchmark) {
          benchmark->Unit(benchmark::kMillisecond);
          benchmark->Iterations(1);
        });
  }
}

}  // namespace hymm::benchmarks
