// How far the compressed filter is from the textbook EKF over a long drive with insertion, removal,
// area switches, GPS and calibration states. One line of CSV for each comparison;
// scripts/experiments/exactness makes figures of it.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "common/serial_worker.h"
#include "support/shadowed_drive.h"
#include "support/worker_hold.h"

namespace hymm::test {
namespace {

// Scans during which a global update stays pending.
constexpr int kPendingScans = 5;

int fail() {
  std::fputs(
      "Usage: exactness STEPS SEED inline|background\n"
      "inline: each global update is carried out at once, then the filters are compared.\n"
      "background: it is held back while the car drives on; the filters are compared with the "
      "update\n"
      "pending, after each scan, and when it is done.\n",
      stderr);
  return 2;
}

void print(int step, bool pending, const ShadowedDrive& drive) {
  const FilterDifference difference = drive.filters().difference();
  std::printf("%d,%d,%.3e,%.3e,%.3e,%.3e,%zu,%.3f\n", step, pending ? 1 : 0, difference.covariance,
              difference.state, difference.asymmetry, difference.least_eigenvalue,
              drive.filters().slots().size(), drive.positionError());
}

void runInline(int steps, std::uint64_t seed) {
  ShadowedDrive drive(seed);
  for (int step = 1; step <= steps; ++step) {
    if (drive.step()) print(step, false, drive);
  }
}

void runInBackground(int steps, std::uint64_t seed) {
  ShadowedDrive drive(seed, core::SerialWorker::Mode::kBackground);
  core::CompressedEkf& filter = drive.filters().compressed();
  auto hold = std::make_unique<WorkerHold>(filter);
  int started = 0;  // step that started the pending update
  for (int step = 1; step <= steps; ++step) {
    if (drive.step()) started = step;
    if (!filter.isGlobalUpdatePending()) continue;
    print(step, true, drive);
    if (step < started + kPendingScans) continue;
    hold.reset();
    filter.finishGlobalUpdate();
    print(step, false, drive);
    hold = std::make_unique<WorkerHold>(filter);
  }
}

}  // namespace
}  // namespace hymm::test

int main(int argc, char** argv) {
  if (argc != 4) return hymm::test::fail();
  const int steps = std::atoi(argv[1]);
  const auto seed = std::strtoull(argv[2], nullptr, 10);
  const std::string mode = argv[3];
  if (steps < 1 || (mode != "inline" && mode != "background")) return hymm::test::fail();
  std::puts("step,pending,covariance,state,asymmetry,least_eigenvalue,landmarks,position_error_m");
  if (mode == "inline") {
    hymm::test::runInline(steps, seed);
  } else {
    hymm::test::runInBackground(steps, seed);
  }
  return 0;
}
