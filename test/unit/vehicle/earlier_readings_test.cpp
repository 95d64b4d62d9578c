#include "vehicle/earlier_readings.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

constexpr double kCorrelationTime_s = 0.2, kStep_s = 0.01;

MotionNoise noise() {
  MotionNoise noise;
  noise.correlation_time_s = kCorrelationTime_s;
  return noise;
}

AckermannInput steered(double steering_rad) { return {0.0, 4.0, steering_rad}; }

TEST(EarlierReadings, AreThoseReadAtFirst) {
  EarlierReadings earlier(noise());
  earlier.begin(steered(0.3));
  EXPECT_DOUBLE_EQ(earlier.readings().forward_mps, 4.0);
  EXPECT_DOUBLE_EQ(earlier.readings().turn, 0.3);
}

TEST(EarlierReadings, FollowWhatIsReadForLong) {
  EarlierReadings earlier(noise());
  earlier.begin(steered(0.0));
  earlier.follow(steered(0.3), 0.2);
  EXPECT_LT(earlier.readings().turn, 0.03);
  earlier.follow(steered(0.3), 10.0);
  EXPECT_NEAR(earlier.readings().turn, 0.3, 1e-4);
}

TEST(EarlierReadings, AreTheSameHoweverTheTimeIsDivided) {
  EarlierReadings once(noise()), often(noise());
  once.begin(TwistInput{});
  often.begin(TwistInput{});
  const TwistInput turning{0.0, 2.0, 0.5, 0.4};
  once.follow(turning, 1.0);
  for (int k = 0; k < 10; ++k) often.follow(turning, 0.1);
  EXPECT_TRUE(once.readings().vector().isApprox(often.readings().vector(), 1e-12));
  EXPECT_GT(once.readings().lateral_mps, 0.1);
}

TEST(EarlierReadings, HoldASixteenthOfThePresentError) {
  // A car that drives straight on, whose steering is read with an error that lasts 0.2 s.
  RandomGenerator generator(7);
  EarlierReadings earlier(noise());
  const double kept = std::exp(-kStep_s / kCorrelationTime_s);
  double error = sampleNormal(generator, 1.0), product = 0.0, square = 0.0;
  earlier.begin(steered(error));
  constexpr int kSteps = 2000000;
  for (int k = 0; k < kSteps; ++k) {
    earlier.follow(steered(error), kStep_s);
    error = kept * error + sampleNormal(generator, std::sqrt(1.0 - kept * kept));
    product += error * earlier.readings().turn;
    square += error * error;
  }
  EXPECT_NEAR(square / kSteps, 1.0, 0.05);
  EXPECT_NEAR(product / square, 1.0 / 16.0, 0.01);
}

}  // namespace
}  // namespace hymm::core
