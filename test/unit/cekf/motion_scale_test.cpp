#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "cekf/cekf_slam.h"
#include "pipeline/sensor_merger.h"
#include "simulation/simulation.h"

namespace hymm::core {
namespace {

struct LearntScale {
  double turn = 1.0;
  double deviation = 0.0;  ///< as the filter has it
};

/// What the filter takes for the scale of the steering after the long straight with which the world
/// `loop` begins. The scale is 1.
LearntScale learnOnTheStraight(std::uint64_t seed) {
  SimulationConfig world;
  world.world.name = "loop";
  world.drive.duration_s = 40.0;
  world.motion.draw_calibration = false;
  world.gps.enabled = false;
  Simulation simulation(world, simulatedCar(), seed);
  CekfSlam slam(CekfSlamConfig{}, simulatedCar());
  SensorMerger merger({});
  while (auto simulated = simulation.next()) {
    merger.push(simulated->event);
    for (const SensorEvent& event : merger.popReady()) slam.process(event);
  }
  return {slam.calibration().turn_scale, std::sqrt(slam.calibrationCovariance()(1, 1))};
}

// What is read of the steering of a car that drives straight on is nothing but its error. Where
// landmarks show that the car does not turn, a scale of zero seems to explain it.
TEST(MotionScale, IsNotDrawnToZeroByASteeringThatIsNothingButItsError) {
  constexpr int kSeeds = 12;
  double sum = 0.0, deviations = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const LearntScale learnt = learnOnTheStraight(static_cast<std::uint64_t>(seed));
    sum += (learnt.turn - 1.0) / kSeeds;
    deviations += (learnt.turn - 1.0) / learnt.deviation / kSeeds;
  }
  EXPECT_NEAR(sum, 0.0, 0.02) << "a deviation of the prior";
  EXPECT_NEAR(deviations, 0.0, 3.0 / std::sqrt(kSeeds));
}

}  // namespace
}  // namespace hymm::core
