#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "pipeline/sensor_merger.h"
#include "simulation/simulation.h"

namespace hymm::core {
namespace {

/// A drive along the loop of look-alike trees, with encoders that are so many times as noisy as the
/// vehicle's configuration claims.
class NoisyDrive {
 public:
  explicit NoisyDrive(double times) {
    SimulationConfig world;
    world.world.name = "loop";
    world.drive.duration_s = 120.0;
    world.motion.noise_scale = times;
    world.gps.enabled = false;
    Simulation simulation(world, simulatedCar(), 301);
    CekfSlam slam(CekfSlamConfig{}, simulatedCar());
    SensorMerger merger({});
    while (auto simulated = simulation.next()) {
      if (std::holds_alternative<ScanEvent>(simulated->event)) {
        truth_[timeOf(simulated->event)] = simulated->T_map_base;
      }
      merger.push(simulated->event);
      for (const SensorEvent& event : merger.popReady()) take(slam.process(event), slam);
    }
    noisy_scans_ = slam.counts().noisy_scans;
  }

  double farthest_m() const { return farthest_m_; }
  double largestFactor() const { return largest_factor_; }
  std::size_t noisyScans() const { return noisy_scans_; }

 private:
  void take(const std::optional<ScanOutcome>& outcome, const CekfSlam& slam) {
    if (!outcome || !outcome->accepted) return;
    const Pose2& truth = truth_.at(outcome->pose.time_s);
    farthest_m_ =
        std::max(farthest_m_, (outcome->pose.T_map_base.position() - truth.position()).norm());
    largest_factor_ = std::max(largest_factor_, slam.motionNoiseFactors().maxCoeff());
  }

  std::map<double, Pose2> truth_;
  double farthest_m_ = 0.0, largest_factor_ = 1.0;
  std::size_t noisy_scans_ = 0;
};

TEST(NoisyMotion, IsBelievedWhereItIsAsClaimed) {
  const NoisyDrive drive(1.0);
  EXPECT_LT(drive.farthest_m(), 1.0);
  EXPECT_LT(drive.largestFactor(), 2.0);
  EXPECT_EQ(drive.noisyScans(), 0U);
}

TEST(NoisyMotion, IsLearntWhereItIsThreeTimesWorseThanClaimed) {
  const NoisyDrive drive(3.0);
  EXPECT_LT(drive.farthest_m(), 2.0);
  EXPECT_GT(drive.largestFactor(), 4.0);
  EXPECT_LT(drive.largestFactor(), 20.0);
  EXPECT_GT(drive.noisyScans(), 300U);
}

}  // namespace
}  // namespace hymm::core
