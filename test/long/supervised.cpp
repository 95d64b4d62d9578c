// A simulated drive with the supervisor in charge, which may switch by itself. Prints "what,..."
// lines of CSV: one `scan` for each scan with the evidence of it, one `switch` for each change of
// mode, and one `end`. With CARRY_AT_S and CARRY_FOR_S the vehicle is carried on along its way, the
// sensor covered and the wheels at rest. scripts/experiments/suspicion and self_recovery make
// figures of it.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "common/angles.h"
#include "pipeline/offline_run.h"
#include "pipeline/results_writer.h"
#include "pipeline/suite_config.h"
#include "simulation/simulation.h"
#include "support/temporary_folder.h"

namespace hymm {
namespace {

struct Arguments {
  std::string world;
  std::uint64_t seed = 0;
  int laps = 1;
  double noise_scale = 1.0;  // times what the encoders claim: the filter's prior is then wrong
  double carry_at_s = 1e9, carry_for_s = 0.0;
  std::vector<std::string> configs;
};

void printScan(const core::SupervisorStage& supervisor, const core::Pose2& truth) {
  const core::SupervisorDecision& decision = supervisor.decision();
  const core::PoseEstimate& pose = supervisor.pose();
  std::printf("scan,%.6g,%s,%.4g", pose.time_s, core::nameOf(decision.mode).c_str(),
              (pose.T_map_base.position() - truth.position()).norm());
  for (const core::EvidenceFigure& figure : decision.figures) {
    if (figure.name != "pose_age_s") std::printf(",%.4g", figure.value);
  }
  std::puts("");
  if (supervisor.hasSwitched()) {
    std::printf("switch,%.6g,%s,\"%s\"\n", pose.time_s, core::nameOf(decision.mode).c_str(),
                decision.reason.c_str());
  }
}

void drive(const Arguments& arguments) {
  core::ConfigReport report;
  core::SuiteConfig suite = core::loadSuiteConfig(arguments.configs, report);
  report.throwIfUnusable();
  core::SimulationConfig world;
  world.world.name = arguments.world;
  world.drive.laps = arguments.laps;
  world.drive.carried_at_s = arguments.carry_at_s;
  world.drive.carried_for_s = arguments.carry_for_s;
  world.motion.noise_scale = arguments.noise_scale;
  world.gps.enabled = false;
  suite.vehicle = core::simulatedCar();
  core::Simulation simulation(world, suite.vehicle, arguments.seed);
  const test::TemporaryFolder folder;
  core::ResultsWriter results(folder.path().string());
  core::OfflineRun run(suite, {"cekf_slam", "hymm_grid", "relocaliser", "supervisor"}, results);
  std::size_t scans = 0;
  core::Pose2 truth, last_truth;
  while (auto simulated = simulation.next()) {
    run.process(simulated->event);
    const bool is_scan = !std::holds_alternative<core::MotionInput>(simulated->event);
    if (is_scan) truth = simulated->T_map_base;
    if (run.scans() == scans) continue;
    scans = run.scans();
    // A scan is released by the motion after it.
    printScan(*run.supervisor(), truth);
    last_truth = truth;
  }
  const core::SupervisorStage& supervisor = *run.supervisor();
  std::printf("end,%.6g,%s,%.4g\n", supervisor.pose().time_s,
              core::nameOf(supervisor.decision().mode).c_str(),
              (supervisor.pose().T_map_base.position() - last_truth.position()).norm());
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  if (argc < 7) {
    std::fprintf(
        stderr, "Usage: supervised WORLD SEED LAPS NOISE_SCALE CARRY_AT_S CARRY_FOR_S CONFIG...\n");
    return 2;
  }
  try {
    hymm::drive({argv[1],
                 std::strtoull(argv[2], nullptr, 10),
                 std::atoi(argv[3]),
                 std::atof(argv[4]),
                 std::atof(argv[5]),
                 std::atof(argv[6]),
                 {argv + 7, argv + argc}});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "supervised: %s\n", error.what());
    return 1;
  }
  return 0;
}
