#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "pipeline/sensor_merger.h"
#include "simulation/simulation.h"

namespace hymm::core {
namespace {

/// A drive with perfect encoders and a laser that turns ten times a second.
class RotatingLaserDrive {
 public:
  RotatingLaserDrive() : simulation_(config(), car(), 7) {}

  static VehicleConfig car() {
    VehicleConfig car = simulatedCar();
    car.calibration = {};
    return car;
  }

  static SimulationConfig config() {
    SimulationConfig config;
    config.drive.duration_s = 20.0;
    config.motion.noise_scale = 0.0;
    config.laser.rotating = true;
    config.laser.rate_hz = 10.0;
    config.laser.field_of_view_rad = 2.0 * kPi;
    config.laser.beams = 720;
    config.laser.range_max_m = 25.0;
    config.gps.enabled = false;
    return config;
  }

  /// Drives; median distance of what is observed from the nearest landmark, seen from where the
  /// vehicle truly was at the stamp. `undo`: whether the time increments are told.
  double errorOfObservations(bool undo) {
    CekfSlam slam(CekfSlamConfig{}, car());
    SensorMerger merger({});
    while (auto simulated = simulation_.next()) {
      if (auto* scan = std::get_if<ScanEvent>(&simulated->event)) {
        truth_[scan->scan.time_s] = simulated->T_map_base;
        if (!undo) scan->scan.time_increment_s = 0.0;
      }
      merger.push(simulated->event);
      for (const SensorEvent& event : merger.popReady()) take(slam.process(event));
    }
    std::nth_element(errors_m_.begin(), errors_m_.begin() + observations() / 2, errors_m_.end());
    return errors_m_[static_cast<std::size_t>(observations() / 2)];
  }

  std::ptrdiff_t observations() const { return static_cast<std::ptrdiff_t>(errors_m_.size()); }

 private:
  void take(const std::optional<ScanOutcome>& outcome) {
    if (!outcome || !outcome->accepted) return;
    const Pose2 T_map_sensor =
        truth_.at(outcome->pose.time_s) * outcome->observations.T_base_sensor;
    for (const Observation& seen : outcome->observations.observations) {
      EXPECT_EQ(seen.after_stamp_s, 0.0);
      const Eigen::Vector2d place =
          T_map_sensor *
          (seen.range_m * Eigen::Vector2d(std::cos(seen.bearing_rad), std::sin(seen.bearing_rad)));
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const TrueLandmark& landmark : simulation_.landmarks()) {
        nearest_m = std::min(nearest_m, (landmark.position - place).norm());
      }
      errors_m_.push_back(nearest_m);
    }
  }

  Simulation simulation_;
  std::map<double, Pose2> truth_;
  std::vector<double> errors_m_;  ///< far off for people and bushes, hence the median
};

TEST(RotatingLaserDrive, ObservationsAreAsOfTheStamp) {
  RotatingLaserDrive told, untold;
  const double with_m = told.errorOfObservations(true);
  const double without_m = untold.errorOfObservations(false);
  EXPECT_GT(told.observations(), 1000);
  EXPECT_LT(with_m, 0.08);             // what the detector leaves, see doc/perception.md
  EXPECT_GT(without_m, 2.0 * with_m);  // up to half a metre, and up to 0.03 rad
}

}  // namespace
}  // namespace hymm::core
