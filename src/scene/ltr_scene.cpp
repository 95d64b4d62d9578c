#include "scene/ltr_scene.h"

#include <algorithm>

namespace hymm::core {

std::optional<Eigen::Vector2d> findPosition(const LandmarkMap& map, int id) {
  const auto place =
      std::lower_bound(map.landmarks.begin(), map.landmarks.end(), id,
                       [](const LandmarkEstimate& landmark, int key) { return landmark.id < key; });
  if (place == map.landmarks.end() || place->id != id) return std::nullopt;
  return place->position;
}

std::optional<Corners> findCorners(const LandmarkMap& map, const LtrTopology& ltr) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<Eigen::Vector2d> position = findPosition(map, ltr.landmark_ids[k]);
    if (!position) return std::nullopt;
    corners[k] = *position;
  }
  return corners;
}

std::array<Eigen::Vector2f, 3> textureCorners(const AtlasPlace& place, int page_size) {
  const auto at = [&](int x, int y) -> Eigen::Vector2f {
    return Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) /
           static_cast<float>(page_size);
  };
  const int left = place.x + 1, low = place.y + 1;
  return {at(left, low), at(left + place.width - 2, low), at(left, low + place.height - 2)};
}

std::vector<std::pair<int, int>> sidesOf(const std::vector<LtrTopology>& ltrs) {
  std::vector<std::pair<int, int>> sides;
  sides.reserve(3 * ltrs.size());
  for (const LtrTopology& ltr : ltrs) {
    for (std::size_t k = 0; k < 3; ++k) {
      sides.emplace_back(std::minmax(ltr.landmark_ids[k], ltr.landmark_ids[(k + 1) % 3]));
    }
  }
  std::sort(sides.begin(), sides.end());
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  return sides;
}

std::array<Eigen::Vector2d, 6> wideLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                        double width_m) {
  const Eigen::Vector2d along = to - from;
  const double length = along.norm();
  const Eigen::Vector2d left =
      length > 0.0 ? Eigen::Vector2d(-along.y(), along.x()) / length : Eigen::Vector2d(0.0, 1.0);
  const Eigen::Vector2d half = 0.5 * width_m * left;
  const Eigen::Vector2d a = from - half, b = to - half, c = to + half, d = from + half;
  return {a, b, c, a, c, d};
}

}  // namespace hymm::core
