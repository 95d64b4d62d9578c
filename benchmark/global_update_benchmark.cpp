// The global update of the compressed EKF by the number of landmarks, beside the bare DSYRK of the
// same shape: the least that a symmetric update of that rank costs.

#include <string>
#include <vector>

#include <Eigen/Core>
#include <cblas.h>

#include "benchmark/benchmarks.h"
#include "cekf/compressed_ekf.h"
#include "common/random.h"

namespace hymm::benchmarks {
namespace {

using core::CompressedEkf;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kVehicleStates = 5;
constexpr int kActiveLandmarks = 80;
constexpr int kOriginStates = kVehicleStates + 2 * kActiveLandmarks;
constexpr int kObservedLandmarks = 12;

Eigen::Matrix<double, 2, Eigen::Dynamic> randomRows(core::RandomGenerator& generator) {
  Eigen::Matrix<double, 2, Eigen::Dynamic> rows(2, kVehicleStates);
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = core::sampleNormal(generator, 1.0);
  return rows;
}

/// A map whose landmarks are all correlated, through the vehicle's states.
CompressedEkf correlatedMap(int landmarks, core::RandomGenerator& generator) {
  constexpr int kBetweenUpdates = 500;
  const MatrixXd I = MatrixXd::Identity(kVehicleStates, kVehicleStates);
  CompressedEkf filter(VectorXd::Zero(kVehicleStates), I);
  for (int i = 0; i < landmarks; ++i) {
    filter.append({core::sampleNormal(generator, 100.0), core::sampleNormal(generator, 100.0)},
                  randomRows(generator), 0.01 * Matrix2d::Identity());
    if (i % kBetweenUpdates == 0) {
      filter.predict(filter.vehicle(), I, 0.1 * I);
      filter.globalUpdate();
    }
  }
  filter.globalUpdate();
  return filter;
}

/// What a drive through one cell leaves to the global update: `kActiveLandmarks` seen again.
void driveThroughCell(CompressedEkf& filter, int landmarks, core::RandomGenerator& generator) {
  const int first = std::uniform_int_distribution<int>(0, landmarks - kActiveLandmarks)(generator);
  std::vector<core::SparseMeasurement> seen;
  for (int slot = first; slot < first + kActiveLandmarks; ++slot) {
    filter.activate(slot);
    if (slot >= first + kObservedLandmarks) continue;
    core::SparseMeasurement measurement;
    measurement.innovation.setConstant(1e-3);
    measurement.H_vehicle = randomRows(generator);
    measurement.landmarks[0] = slot;
    measurement.H_landmarks[0] = Matrix2d::Identity();
    measurement.noise = 0.1 * Matrix2d::Identity();
    seen.push_back(measurement);
  }
  filter.update(seen);
}

void globalUpdate(benchmark::State& state, int landmarks) {
  core::RandomGenerator generator(1);
  CompressedEkf filter = correlatedMap(landmarks, generator);
  for (auto _ : state) {
    state.PauseTiming();
    driveThroughCell(filter, landmarks, generator);
    state.ResumeTiming();
    filter.globalUpdate();
  }
  state.counters["origin_states"] = kOriginStates;
}

void dsyrk(benchmark::State& state, int landmarks) {
  openblas_set_num_threads(1);
  const int n = 2 * landmarks;
  const MatrixXd A = MatrixXd::Constant(n, kOriginStates, 1e-3);
  MatrixXd C = MatrixXd::Zero(n, n);
  for (auto _ : state) {
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, kOriginStates, -1.0, A.data(), n, 1.0,
                C.data(), n);
    benchmark::ClobberMemory();
  }
  state.counters["origin_states"] = kOriginStates;
}

}  // namespace

void registerGlobalUpdateBenchmarks(Registration& registration) {
  const auto in_milliseconds = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMillisecond);
  };
  for (const int n : {100, 300, 1000, 3000, 10000}) {
    registration.add(
        "BM_GlobalUpdate/" + std::to_string(n),
        [n](benchmark::State& state) { globalUpdate(state, n); }, in_milliseconds);
  }
  for (const int n : {100, 300, 1000, 3000, 10000}) {
    registration.add(
        "BM_Dsyrk/" + std::to_string(n), [n](benchmark::State& state) { dsyrk(state, n); },
        in_milliseconds);
  }
}

}  // namespace hymm::benchmarks
