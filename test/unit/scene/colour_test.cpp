#include "scene/colour.h"

#include <cmath>

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

double distance(const Colour& a, const Colour& b) {
  return std::hypot(static_cast<double>(a.red - b.red), static_cast<double>(a.green - b.green),
                    static_cast<double>(a.blue - b.blue));
}

TEST(Colour, BecomesAPixelWithinItsBounds) {
  EXPECT_EQ(pixelOf({0.0F, 0.5F, 1.0F, 2.0F}), (Pixel{0, 128, 255, 255}));
}

TEST(Colour, TellsTypesOfLandmarksApart) {
  EXPECT_GT(distance(colourOf(LandmarkType::kTrunk), colourOf(LandmarkType::kReflector)), 0.5);
  EXPECT_GT(distance(colourOf(LandmarkType::kTrunk), colourOf(LandmarkType::kUnknown)), 0.5);
}

TEST(Colour, GetsBrighterAlongTheRamp) {
  double before = -1.0;
  for (int i = 0; i <= 10; ++i) {
    const Colour colour = rampColour(0.1 * i);
    const double brightness = static_cast<double>(colour.red + colour.green + colour.blue);
    EXPECT_GT(brightness, before);
    before = brightness;
  }
}

TEST(Colour, ClampsWhatLiesBeyondTheRamp) {
  EXPECT_EQ(distance(rampColour(-3.0), rampColour(0.0)), 0.0);
  EXPECT_EQ(distance(rampColour(7.0), rampColour(1.0)), 0.0);
}

TEST(Colour, DiffersForNumbersThatFollowOneAnother) {
  for (int number = 0; number < 20; ++number) {
    for (int next = number + 1; next < number + 4; ++next) {
      EXPECT_GT(distance(distinctColour(number), distinctColour(next)), 0.25)
          << number << " " << next;
    }
  }
}

}  // namespace
}  // namespace hymm::core
