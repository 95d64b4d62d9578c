#pragma once

#include <array>
#include <cstdint>

#include "perception/observation.h"

/// The colours in which maps are shown.
namespace hymm::core {

/// Shares of red, green, blue and opacity, 0 to 1.
struct Colour {
  float red = 0.0F, green = 0.0F, blue = 0.0F, alpha = 1.0F;
};

/// Red, green, blue and opacity, 0 to 255.
using Pixel = std::array<std::uint8_t, 4>;

Pixel pixelOf(const Colour& colour);

/// Green trunks, orange reflectors, grey for what is of no known type.
Colour colourOf(LandmarkType type);

/// From free (slate) to occupied (red); `probability` 0 to 1, nothing is known at 0.5.
Colour occupancyColour(double probability);

/// From deep blue by green to yellow, ever brighter, for `share` 0 to 1.
Colour rampColour(double share);

/// Colours that differ for numbers that follow one another: categories, islands.
Colour distinctColour(int number);

}  // namespace hymm::core
