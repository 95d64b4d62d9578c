#include "vehicle/earlier_readings.h"

namespace hymm::core {
namespace {

constexpr double kLagInCorrelationTimes = 3.0;

}  // namespace

EarlierReadings::EarlierReadings(const MotionNoise& noise) {
  const Eigen::Vector3d times_s = noise.correlationTimes_s();
  lag_s_ = kLagInCorrelationTimes * Eigen::Array3d(times_s[0], times_s[0], times_s[1]);
}

void EarlierReadings::begin(const MotionInput& input) {
  smoothed_ = delayed_ = readingsOf(input).vector();
}

void EarlierReadings::follow(const MotionInput& input, double duration_s) {
  const Eigen::Vector3d read = readingsOf(input).vector();
  // With `read` constant from now on: its distances from both lags decay, the second one's as
  // (d_delayed + d_smoothed * t / lag) * exp(-t / lag).
  const Eigen::Array3d lags = duration_s / lag_s_, kept = (-lags).exp();
  const Eigen::Array3d from_smoothed = smoothed_ - read, from_delayed = delayed_ - read;
  delayed_ = read + ((from_delayed + lags * from_smoothed) * kept).matrix();
  smoothed_ = read + (from_smoothed * kept).matrix();
}

}  // namespace hymm::core
