// Level sets while a map changes: what the incremental search evaluates, against every cell and
// against a quadtree from scratch, and whether the sets are the same. One line of CSV for each
// change of the map; scripts/experiments/level_sets makes figures of it.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "common/error.h"
#include "datasets/acfr_recording.h"
#include "information_map/full_evaluation.h"
#include "information_map/level_quadtree.h"
#include "information_map/level_set_search.h"
#include "pipeline/suite_config.h"
#include "support/map_history.h"

namespace hymm::test {
namespace {

using core::LevelSetSearch;
using Clock = std::chrono::steady_clock;

int fail() {
  std::fputs(
      "Usage: level_sets CONFIG.yaml simulation:WORLD:SEED:LAPS|victoria_park:ARCHIVE CHANGES "
      "COMPARE_EVERY FOLDER\n"
      "Every COMPARE_EVERY changes the sets are compared with a full evaluation; FOLDER gets "
      "their leaves and the landmarks then.\n",
      stderr);
  return 2;
}

core::SuiteConfig loadSuite(const std::string& file) {
  core::ConfigReport report;
  core::SuiteConfig config = core::loadSuiteConfig({file}, report);
  report.throwIfUnusable();
  return config;
}

/// Sensor events of an ACFR recording, in its own order.
MapHistory recordedHistory(const std::string& archive, const core::SuiteConfig& config) {
  auto recording = std::make_shared<core::AcfrRecording>(core::readAcfr({archive}));
  auto next = std::make_shared<std::size_t>(0);
  const core::Pose2 T_base_laser = config.vehicle.laser.T_base_sensor();
  const auto source = [recording, next, T_base_laser]() -> std::optional<core::SensorEvent> {
    while (*next < recording->events.size()) {
      const auto& event = recording->events[(*next)++];
      if (event.sensor == core::AcfrSensor::kMotion) {
        return core::MotionInput{recording->motion[event.index]};
      }
      if (event.sensor == core::AcfrSensor::kLaser) {
        return core::ScanEvent{recording->scans[event.index], T_base_laser};
      }
    }
    return std::nullopt;
  };
  return MapHistory(source, config.cekf_slam, config.vehicle, 1.0,
                    config.cekf_slam.landmark_block_range_m);
}

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void writeSnapshot(const std::string& folder, int change, const LevelSetSearch& search,
                   const core::LandmarkMap& map) {
  char name[32];
  std::snprintf(name, sizeof name, "%05d", change);
  std::ofstream leaves(std::filesystem::path(folder) / ("leaves_" + std::string(name) + ".csv"));
  leaves << "value,x,y,edge,island\n";
  for (int level = 1; level <= search.lattice().levels(); ++level) {
    for (const core::LevelLeaf& leaf :
         quadtreeLeaves(search.lattice(), level, search.islands(level))) {
      leaves << search.values()[std::size_t(level - 1)] << ',' << leaf.centre.x() << ','
             << leaf.centre.y() << ',' << leaf.edge_m << ',' << leaf.island << '\n';
    }
  }
  std::ofstream landmarks(std::filesystem::path(folder) /
                          ("landmarks_" + std::string(name) + ".csv"));
  landmarks << "id,x,y,cxx,cxy,cyy\n";
  for (const core::LandmarkEstimate& landmark : map.landmarks) {
    landmarks << landmark.id << ',' << landmark.position.x() << ',' << landmark.position.y() << ','
              << landmark.covariance(0, 0) << ',' << landmark.covariance(0, 1) << ','
              << landmark.covariance(1, 1) << '\n';
  }
}

void printHeader(std::size_t levels) {
  std::printf("change,time_s,landmarks,evaluations,update_ms,islands");
  for (std::size_t l = 0; l < levels; ++l) {
    std::printf(",area_%zu,gained_%zu,lost_%zu,lost_moving_%zu,kept_%zu", l, l, l, l, l);
  }
  std::printf(",full_evaluations,full_ms,scratch_evaluations,scratch_ms");
  for (std::size_t l = 0; l < levels; ++l) std::printf(",iou_%zu,scratch_iou_%zu", l, l);
  std::printf("\n");
}

void printComparison(const core::InformationMapConfig& config, const LevelSetSearch& search,
                     const std::shared_ptr<const core::LandmarkField>& field) {
  auto start = Clock::now();
  const core::FullEvaluation full = evaluateFully(config, *field);
  const double full_ms = millisecondsSince(start);
  core::InformationMapConfig unbounded = config;
  unbounded.level_sets.max_evaluations = 1000000000;
  LevelSetSearch scratch(unbounded);
  start = Clock::now();
  const core::LevelSetUpdate built = scratch.update(field, Eigen::Vector2d::Zero());
  std::printf(",%zu,%.3f,%zu,%.3f", full.evaluations, full_ms, built.evaluations,
              millisecondsSince(start));
  for (int level = 1; level <= search.lattice().levels(); ++level) {
    std::printf(",%.6f,%.6f", intersectionOverUnion(search.lattice(), full.lattice, level),
                intersectionOverUnion(scratch.lattice(), full.lattice, level));
  }
}

void run(const core::InformationMapConfig& config, MapHistory& history, int changes,
         int compare_every, const std::string& folder) {
  LevelSetSearch search(config);
  printHeader(search.values().size());
  for (int change = 1; change <= changes; ++change) {
    const auto version = history.next();
    if (!version) break;
    const auto field = std::make_shared<const core::LandmarkField>(
        version->map, config.information.sensor.range_m);
    const auto start = Clock::now();
    const core::LevelSetUpdate update = search.update(field, version->pose.T_map_base.position());
    std::printf("%d,%.3f,%d,%zu,%.3f,%zu", change, version->pose.time_s, field->size(),
                update.evaluations, millisecondsSince(start), search.islands(1).islands().size());
    for (const core::LevelChange& level : update.levels) {
      std::printf(",%.1f,%.1f,%.1f,%.1f,%.1f", level.area_m2, level.gained_m2, level.lost_m2,
                  level.lost_moving_m2, level.kept_m2);
    }
    if (change % compare_every == 0) {
      printComparison(config, search, field);
      writeSnapshot(folder, change, search, version->map);
    } else {
      std::printf(",,,,");
      for (std::size_t l = 0; l < search.values().size(); ++l) std::printf(",,");
    }
    std::printf("\n");
  }
}

int main(int argc, char** argv) {
  if (argc != 6) return fail();
  const core::SuiteConfig suite = loadSuite(argv[1]);
  const core::InformationMapConfig& config = suite.information_map;
  const std::string source = argv[2];
  const int changes = std::atoi(argv[3]), compare_every = std::atoi(argv[4]);
  if (changes < 1 || compare_every < 1) return fail();
  std::filesystem::create_directories(argv[5]);
  char world[64] = "";
  unsigned seed = 0;
  int laps = 0;
  if (std::sscanf(source.c_str(), "simulation:%63[a-z_]:%u:%d", world, &seed, &laps) == 3) {
    MapHistory history = simulatedHistory(world, laps, seed);
    run(config, history, changes, compare_every, argv[5]);
  } else if (source.rfind("victoria_park:", 0) == 0) {
    MapHistory history = recordedHistory(source.substr(14), suite);
    run(config, history, changes, compare_every, argv[5]);
  } else {
    return fail();
  }
  return 0;
}

}  // namespace
}  // namespace hymm::test

int main(int argc, char** argv) {
  try {
    return hymm::test::main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "level_sets: %s\n", error.what());
    return 1;
  }
}
