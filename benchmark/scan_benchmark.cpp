// The cost of a scan by the number of landmarks, in the world `plain`: hymm's engine CekfSlam from
// detections to pose, and a dense EKF that is given the same observations.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "benchmark/benchmarks.h"
#include "benchmark/dense_slam.h"
#include "benchmark/plain_drive.h"
#include "cekf/cekf_slam.h"

namespace hymm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

// Until the car has its speed and the landmarks around the start are active.
constexpr int kWarmUpScans = 40;

/// Lets scans begin at an even rate, as a live sensor does.
class Pace {
 public:
  explicit Pace(const ScanOptions& options)
      : period_(options.live_speed > 0.0 ? 1.0 / (PlainDrive::kScanRate_hz * options.live_speed)
                                         : 0.0),
        stays_awake_(options.stays_awake),
        next_(Clock::now()) {}

  void wait() {
    if (!stays_awake_) std::this_thread::sleep_until(next_);
    while (Clock::now() < next_) {
    }
    next_ += std::chrono::duration_cast<Clock::duration>(period_);
  }

 private:
  std::chrono::duration<double> period_;
  bool stays_awake_;
  Clock::time_point next_;
};

/// Lets `perf record --control fifo:FIFO --delay -1` record while it lives.
class PerfControl {
 public:
  explicit PerfControl(const std::string& fifo) {
    if (fifo.empty()) return;
    fifo_.open(fifo);
    fifo_ << "enable" << std::endl;
  }
  ~PerfControl() {
    if (fifo_.is_open()) fifo_ << "disable" << std::endl;
  }
  PerfControl(const PerfControl&) = delete;
  PerfControl& operator=(const PerfControl&) = delete;

 private:
  std::ofstream fifo_;
};

/// Wall times of scans.
class Latencies {
 public:
  void add(benchmark::State& state, Clock::duration duration) {
    const double seconds = std::chrono::duration<double>(duration).count();
    state.SetIterationTime(seconds);
    milliseconds_.push_back(1e3 * seconds);
  }

  void report(benchmark::State& state) {
    double sum = 0.0;
    for (const double ms : milliseconds_) sum += ms;
    std::sort(milliseconds_.begin(), milliseconds_.end());
    state.counters["scan_ms"] = sum / static_cast<double>(milliseconds_.size());
    state.counters["scan_ms_p50"] = quantile(0.5);
    state.counters["scan_ms_p95"] = quantile(0.95);
    state.counters["scan_ms_p99"] = quantile(0.99);
    state.counters["scan_ms_p999"] = quantile(0.999);
    state.counters["scan_ms_max"] = milliseconds_.back();
  }

 private:
  /// The least value that a share of at least `share` does not exceed.
  double quantile(double share) const {
    const double rank = std::ceil(share * static_cast<double>(milliseconds_.size()));
    return milliseconds_[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
  }

  std::vector<double> milliseconds_;
};

void process(core::CekfSlam& slam, const ScanPeriod& period) {
  for (const core::MotionInput& input : period.motion) slam.process(input);
  slam.process(period.set);
}

double positionError(const core::Pose2& estimate, const ScanPeriod& period) {
  return (estimate.position() - period.T_map_base.position()).norm();
}

void scanCompressedEkf(benchmark::State& state, int landmarks, const ScanOptions& options) {
  const PlainDrive plain = makePlainDrive(landmarks, kWarmUpScans + options.scans);
  core::CekfSlamConfig config;
  config.motion_input = "odom";
  config.observation_input = "detections";
  core::CekfSlam slam(config, plain.vehicle, core::CekfSlam::GlobalUpdates::kBackground);
  for (const ScanPeriod& period : plain.survey) {
    process(slam, period);
    while (slam.isGlobalUpdatePending()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  Pace pace(options);
  Latencies latencies;
  std::size_t scan = 0;
  for (; scan < kWarmUpScans; ++scan) {
    pace.wait();
    process(slam, plain.drive[scan]);
  }
  const core::CekfSlam::Counts before = slam.counts();
  const double worker_before_s = slam.cpuTimes().worker_s;
  const PerfControl perf(options.perf_control);
  double observations = 0.0;
  for (auto _ : state) {
    const ScanPeriod& period = plain.drive[scan++];
    pace.wait();
    const auto start = Clock::now();
    process(slam, period);
    latencies.add(state, Clock::now() - start);
    observations += static_cast<double>(period.set.observations.size());
  }
  const auto scans = static_cast<double>(state.iterations());
  latencies.report(state);
  const core::CekfSlam::Counts after = slam.counts();
  state.counters["worker_ms"] = 1e3 * (slam.cpuTimes().worker_s - worker_before_s) / scans;
  state.counters["area_switches"] = static_cast<double>(after.area_switches - before.area_switches);
  state.counters["global_updates"] =
      static_cast<double>(after.global_updates - before.global_updates);
  state.counters["scans_that_waited"] =
      static_cast<double>(after.global_update_waits - before.global_update_waits);
  state.counters["observations"] = observations / scans;
  state.counters["landmarks"] = static_cast<double>(slam.landmarkCount());
  state.counters["position_error_m"] = positionError(slam.pose().T_map_base, plain.drive[scan - 1]);
}

void scanFullEkf(benchmark::State& state, int landmarks, int scans) {
  const PlainDrive plain = makePlainDrive(landmarks, kWarmUpScans + scans);
  DenseSlam slam(plain.vehicle, landmarks);
  for (const ScanPeriod& period : plain.survey) slam.process(period);
  std::size_t scan = 0;
  for (; scan < kWarmUpScans; ++scan) slam.process(plain.drive[scan]);
  Latencies latencies;
  for (auto _ : state) {
    const auto start = Clock::now();
    slam.process(plain.drive[scan++]);
    latencies.add(state, Clock::now() - start);
  }
  latencies.report(state);
  state.counters["landmarks"] = slam.landmarkCount();
  state.counters["position_error_m"] = positionError(slam.pose(), plain.drive[scan - 1]);
}

/// As many scans of the dense EKF as take about ten seconds.
int bearableScans(int landmarks, int scans) {
  const double scan_s = 4e-9 * landmarks * landmarks;
  return std::clamp(static_cast<int>(10.0 / scan_s), 1, scans);
}

}  // namespace

void registerScanBenchmarks(Registration& registration, const ScanOptions& options) {
  for (const int n : {100, 300, 1000, 3000, 10000}) {
    registration.add(
        "BM_ScanCompressedEkf/" + std::to_string(n),
        [n, options](benchmark::State& state) { scanCompressedEkf(state, n, options); },
        [&](benchmark::internal::Benchmark* benchmark) {
          benchmark->Iterations(options.scans)->UseManualTime()->Unit(benchmark::kMillisecond);
        });
  }
  for (const int n : {100, 300, 1000, 3000, 10000}) {
    const int scans = bearableScans(n, options.scans);
    registration.add(
        "BM_ScanFullEkf/" + std::to_string(n),
        [n, scans](benchmark::State& state) { scanFullEkf(state, n, scans); },
        [&](benchmark::internal::Benchmark* benchmark) {
          benchmark->Iterations(scans)->UseManualTime()->Unit(benchmark::kMillisecond);
        });
  }
}

}  // namespace hymm::benchmarks
