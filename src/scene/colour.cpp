#include "scene/colour.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

// Turning the hue by this share of the circle each time keeps all colours so far far apart.
constexpr double kGoldenRatio = 0.6180339887498949;

Colour mixed(const Colour& from, const Colour& to, double share) {
  const auto s = static_cast<float>(std::clamp(share, 0.0, 1.0));
  return {from.red + s * (to.red - from.red), from.green + s * (to.green - from.green),
          from.blue + s * (to.blue - from.blue), from.alpha + s * (to.alpha - from.alpha)};
}

std::uint8_t byteOf(float share) {
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(share, 0.0F, 1.0F)));
}

/// Share of one of the three primaries at a hue, 0 to 1 around the circle from the primary.
float primaryAt(double distance) {
  const double apart = std::abs(distance - std::round(distance));  // 0 to 0.5
  return static_cast<float>(std::clamp(2.0 - 6.0 * apart, 0.0, 1.0));
}

}  // namespace

Pixel pixelOf(const Colour& colour) {
  return {byteOf(colour.red), byteOf(colour.green), byteOf(colour.blue), byteOf(colour.alpha)};
}

Colour colourOf(LandmarkType type) {
  switch (type) {
    case LandmarkType::kTrunk:
      return {0.25F, 0.85F, 0.35F};
    case LandmarkType::kReflector:
      return {1.00F, 0.65F, 0.10F};
    case LandmarkType::kUnknown:
      break;
  }
  return {0.70F, 0.75F, 0.85F};
}

Colour occupancyColour(double probability) {
  constexpr Colour kFree = {0.30F, 0.35F, 0.40F};
  constexpr Colour kUndecided = {0.45F, 0.38F, 0.40F};
  constexpr Colour kOccupied = {0.95F, 0.38F, 0.30F};
  return probability < 0.5 ? mixed(kFree, kUndecided, 2.0 * probability)
                           : mixed(kUndecided, kOccupied, 2.0 * probability - 1.0);
}

Colour rampColour(double share) {
  constexpr Colour kLow = {0.15F, 0.15F, 0.45F};
  constexpr Colour kMiddle = {0.10F, 0.60F, 0.55F};
  constexpr Colour kHigh = {1.00F, 0.95F, 0.30F};
  return share < 0.5 ? mixed(kLow, kMiddle, 2.0 * share) : mixed(kMiddle, kHigh, 2.0 * share - 1.0);
}

Colour distinctColour(int number) {
  const double hue = std::fmod(kGoldenRatio * (std::abs(static_cast<double>(number)) + 1.0), 1.0);
  const Colour pure = {primaryAt(hue), primaryAt(hue - 1.0 / 3.0), primaryAt(hue - 2.0 / 3.0)};
  return mixed(pure, {1.0F, 1.0F, 1.0F}, 0.25);
}

}  // namespace hymm::core
