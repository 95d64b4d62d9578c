#include "benchmark/plain_drive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/random.h"
#include "simulation/simulation.h"

namespace hymm::benchmarks {
namespace {

using core::Pose2;
using core::TrueLandmark;
using Eigen::Vector2d;

constexpr std::uint64_t kSeed = 1;
constexpr double kSquare_m = 100.0;
constexpr std::size_t kTies = 10;  // known landmarks that each stop measures
constexpr double kSpeed_mps = 5.0;
constexpr double kTurnRate_radps = 0.5;
constexpr double kInputPeriod_s = 0.1;

core::SimulationConfig plainWorld(int landmarks, int scans) {
  core::SimulationConfig config;
  config.world.name = "plain";
  config.world.landmarks = landmarks;
  config.drive.laps = 1000;  // the duration ends the drive
  config.drive.duration_s = (scans + 1) / PlainDrive::kScanRate_hz;
  config.motion.output = "odom";
  config.motion.draw_calibration = false;  // else the survey has learnt another one
  config.laser.enabled = false;
  config.gps.enabled = false;
  config.detections.enabled = true;
  config.detections.identities = true;
  config.detections.rate_hz = PlainDrive::kScanRate_hz;
  config.detections.range_max_m = PlainDrive::kRange_m;
  return config;
}

/// A robot that turns in place and drives straight, exactly as its odometry says, through the
/// centres of squares that cover all landmarks, and back to where it began.
class Survey {
 public:
  Survey(const std::vector<TrueLandmark>& landmarks, const Pose2& T_base_sensor,
         const core::SimulatedDetectorConfig& detector)
      : landmarks_(landmarks),
        surveyed_(landmarks.size(), false),
        T_base_sensor_(T_base_sensor),
        detector_(detector),
        generator_(kSeed) {
    low_ = high_ = landmarks.front().position;
    for (const TrueLandmark& landmark : landmarks) {
      low_ = low_.cwiseMin(landmark.position);
      high_ = high_.cwiseMax(landmark.position);
    }
    squares_ = ((high_ - low_) / kSquare_m).array().round().max(1.0).cast<int>();
  }

  std::vector<ScanPeriod> run() {
    stop();
    for (int row = 0; row < squares_.y(); ++row) {
      for (int i = 0; i < squares_.x(); ++i) {
        goTo(centreOf({row % 2 == 0 ? i : squares_.x() - 1 - i, row}));
      }
    }
    goTo(Vector2d::Zero());
    turn(0.0);
    stop();
    shiftTimesToEndAt(core::Simulation::kStartTime_s);
    return std::move(periods_);
  }

 private:
  Vector2d squareSize() const { return (high_ - low_).cwiseQuotient(squares_.cast<double>()); }
  Vector2d centreOf(const Eigen::Vector2i& square) const {
    return low_ + (square.cast<double>().array() + 0.5).matrix().cwiseProduct(squareSize());
  }
  Eigen::Vector2i squareOf(const Vector2d& place) const {
    const Vector2d share = (place - low_).cwiseQuotient(squareSize());
    return share.array().floor().cast<int>().max(0).min(squares_.array() - 1);
  }

  /// In hops of at most a square, with a stop after each.
  void goTo(const Vector2d& target) {
    const Vector2d start = pose_.position();
    const double way_m = (target - start).norm();
    if (way_m < 1e-6) return;
    turn(std::atan2(target.y() - start.y(), target.x() - start.x()));
    const int hops = static_cast<int>(std::ceil(way_m / (1.5 * kSquare_m)));
    for (int i = 0; i < hops; ++i) {
      move(way_m / hops, 0.0, way_m / hops / kSpeed_mps);
      stop();
    }
  }

  void turn(double yaw_rad) {
    const double angle = core::wrapAngle(yaw_rad - pose_.yaw_rad);
    if (std::abs(angle) > 1e-9) move(0.0, angle, std::abs(angle) / kTurnRate_radps);
  }

  void move(double way_m, double angle_rad, double duration_s) {
    const int steps = std::max(1, static_cast<int>(std::ceil(duration_s / kInputPeriod_s)));
    const double time_s = steps * kInputPeriod_s;
    for (int i = 0; i < steps; ++i) input(way_m / time_s, angle_rad / time_s);
    const Vector2d place = pose_.position() + pose_.rotation() * Vector2d(way_m, 0.0);
    pose_ = {place.x(), place.y(), core::wrapAngle(pose_.yaw_rad + angle_rad)};
  }

  void wait() { input(0.0, 0.0); }

  void input(double speed_mps, double yaw_rate_radps) {
    motion_.push_back(core::TwistInput{time_s_, speed_mps, 0.0, yaw_rate_radps});
    time_s_ += kInputPeriod_s;
  }

  /// Measures the landmarks of this square that are not yet known, and the nearest known ones.
  void stop() {
    wait();
    const Vector2d here = pose_.position();
    std::vector<std::size_t> known, chosen;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      if (surveyed_[i]) {
        known.push_back(i);
      } else if (squareOf(landmarks_[i].position) == squareOf(here)) {
        chosen.push_back(i);
      }
    }
    const auto ties = known.begin() + static_cast<std::ptrdiff_t>(std::min(kTies, known.size()));
    std::partial_sort(known.begin(), ties, known.end(), [&](std::size_t a, std::size_t b) {
      return (landmarks_[a].position - here).norm() < (landmarks_[b].position - here).norm();
    });
    chosen.insert(chosen.end(), known.begin(), ties);

    ScanPeriod period;
    period.set = {time_s_ - 0.5 * kInputPeriod_s, T_base_sensor_, {}};
    period.T_map_base = pose_;
    for (const std::size_t i : chosen) {
      surveyed_[i] = true;
      period.set.observations.push_back(measured(landmarks_[i]));
      period.identities.push_back(landmarks_[i].id);
    }
    period.motion = std::move(motion_);
    motion_.clear();
    periods_.push_back(std::move(period));
  }

  core::Observation measured(const TrueLandmark& landmark) {
    const Vector2d p = inverse(pose_ * T_base_sensor_) * landmark.position;
    const Vector2d deviation(detector_.range_deviation_m, detector_.bearing_deviation_rad);
    core::Observation observation;
    observation.range_m = p.norm() + core::sampleNormal(generator_, deviation[0]);
    observation.bearing_rad =
        core::wrapAngle(std::atan2(p.y(), p.x()) + core::sampleNormal(generator_, deviation[1]));
    observation.covariance = deviation.cwiseAbs2().asDiagonal();
    observation.type = landmark.type;
    observation.diameter_m =
        landmark.diameter_m + core::sampleNormal(generator_, detector_.diameter_deviation_m);
    observation.diameter_variance = std::pow(detector_.diameter_deviation_m, 2);
    observation.identity = landmark.id;
    return observation;
  }

  void shiftTimesToEndAt(double end_s) {
    const double shift_s = end_s - time_s_;
    for (ScanPeriod& period : periods_) {
      period.set.time_s += shift_s;
      for (core::MotionInput& input : period.motion) {
        std::get<core::TwistInput>(input).time_s += shift_s;
      }
    }
  }

  const std::vector<TrueLandmark>& landmarks_;
  std::vector<bool> surveyed_;
  Pose2 T_base_sensor_;
  core::SimulatedDetectorConfig detector_;
  core::RandomGenerator generator_;
  Vector2d low_, high_;
  Eigen::Vector2i squares_;
  Pose2 pose_;
  double time_s_ = 0.0;
  std::vector<core::MotionInput> motion_;
  std::vector<ScanPeriod> periods_;
};

}  // namespace

PlainDrive makePlainDrive(int landmarks, int scans) {
  PlainDrive plain;
  plain.vehicle = core::simulatedCar();
  const core::SimulationConfig config = plainWorld(landmarks, scans);
  core::Simulation simulation(config, plain.vehicle, kSeed);
  plain.survey =
      Survey(simulation.landmarks(), plain.vehicle.laser.T_base_sensor(), config.detections).run();

  ScanPeriod period;
  while (auto simulated = simulation.next()) {
    if (auto* input = std::get_if<core::MotionInput>(&simulated->event)) {
      period.motion.push_back(*input);
    } else if (auto* set = std::get_if<core::ObservationSet>(&simulated->event)) {
      period.set = std::move(*set);
      period.T_map_base = simulated->T_map_base;
      for (core::Observation& observation : period.set.observations) {
        period.identities.push_back(observation.identity);
        observation.identity = -1;
      }
      plain.drive.push_back(std::move(period));
      period = {};
    }
  }
  if (plain.drive.size() < static_cast<std::size_t>(scans)) {
    throw std::runtime_error("The simulated drive ended after " +
                             std::to_string(plain.drive.size()) + " scans.");
  }
  return plain;
}

}  // namespace hymm::benchmarks
