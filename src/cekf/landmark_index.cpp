#include "cekf/landmark_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {

void LandmarkIndex::place(int slot, const Eigen::Vector2d& position) {
  const Key key = keyOf(cellOf(position.x()), cellOf(position.y()));
  const auto known = key_of_slot_.find(slot);
  if (known != key_of_slot_.end()) {
    if (known->second == key) return;
    remove(slot);
  }
  key_of_slot_[slot] = key;
  cells_[key].push_back(slot);
}

void LandmarkIndex::remove(int slot) {
  const auto known = key_of_slot_.find(slot);
  if (known == key_of_slot_.end()) return;
  const auto cell = cells_.find(known->second);
  cell->second.erase(std::find(cell->second.begin(), cell->second.end(), slot));
  if (cell->second.empty()) cells_.erase(cell);
  key_of_slot_.erase(known);
}

void LandmarkIndex::clear() {
  cells_.clear();
  key_of_slot_.clear();
}

std::vector<int> LandmarkIndex::near(const Eigen::Vector2d& centre, double radius_m) const {
  std::vector<int> slots;
  const auto take = [&](const std::vector<int>& cell) {
    slots.insert(slots.end(), cell.begin(), cell.end());
  };
  const std::int64_t x0 = cellOf(centre.x() - radius_m), x1 = cellOf(centre.x() + radius_m);
  const std::int64_t y0 = cellOf(centre.y() - radius_m), y1 = cellOf(centre.y() + radius_m);
  const double cells = static_cast<double>(x1 - x0 + 1) * static_cast<double>(y1 - y0 + 1);
  // A vehicle that has been lost for long looks for landmarks in more cells than there are.
  if (cells > static_cast<double>(cells_.size())) {
    for (const auto& [key, cell] : cells_) {
      const std::int64_t x = key >> 32U, y = static_cast<std::int32_t>(key & 0xffffffff);
      if (x >= x0 && x <= x1 && y >= y0 && y <= y1) take(cell);
    }
  } else {
    for (std::int64_t x = x0; x <= x1; ++x) {
      for (std::int64_t y = y0; y <= y1; ++y) {
        const auto cell =
            cells_.find(keyOf(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)));
        if (cell != cells_.end()) take(cell->second);
      }
    }
  }
  std::sort(slots.begin(), slots.end());
  return slots;
}

std::int32_t LandmarkIndex::cellOf(double coordinate) {
  constexpr double kFarthest = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(
      std::clamp(std::floor(coordinate / kCell_m), -kFarthest, kFarthest));
}

LandmarkIndex::Key LandmarkIndex::keyOf(std::int32_t x, std::int32_t y) {
  const auto low = static_cast<std::uint64_t>(static_cast<std::uint32_t>(y));
  return static_cast<Key>(static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32U | low);
}

}  // namespace hymm::core
