#include "hybrid_map/occupancy_image.h"

#include <algorithm>
#include <array>

#include "hybrid_map/log_odds.h"

namespace hymm::core {
namespace {

constexpr int kPercents = 100;

/// Log-odds above which each percent begins.
std::array<float, kPercents> percentBounds() {
  std::array<float, kPercents> bounds{};
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    bounds[i] = static_cast<float>(logOddsOf((static_cast<double>(i) + 0.5) / kPercents));
  }
  return bounds;
}

}  // namespace

std::int8_t occupancyPercent(float log_odds) {
  static const std::array<float, kPercents> kBounds = percentBounds();
  if (log_odds == 0.0F) return OccupancyImage::kUnknown;
  const auto bound = std::lower_bound(kBounds.begin(), kBounds.end(), log_odds);
  return static_cast<std::int8_t>(bound - kBounds.begin());
}

}  // namespace hymm::core
