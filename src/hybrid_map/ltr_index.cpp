#include "hybrid_map/ltr_index.h"

namespace hymm::core {

void LtrIndex::place(int ltr, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  if (cells_.size() <= std::size_t(ltr)) cells_.resize(std::size_t(ltr) + 1);
  const Cells now = cellsOf(low, high);
  if (cells_[std::size_t(ltr)] == now) return;
  remove(ltr);
  cells_[std::size_t(ltr)] = now;
  for (std::int32_t x = now.x0; x <= now.x1; ++x) {
    for (std::int32_t y = now.y0; y <= now.y1; ++y) content_[keyOf(x, y)].push_back(ltr);
  }
}

void LtrIndex::remove(int ltr) {
  Cells& cells = cells_[std::size_t(ltr)];
  for (std::int32_t x = cells.x0; x <= cells.x1; ++x) {
    for (std::int32_t y = cells.y0; y <= cells.y1; ++y) {
      const auto cell = content_.find(keyOf(x, y));
      std::vector<int>& ltrs = cell->second;
      ltrs.erase(std::find(ltrs.begin(), ltrs.end(), ltr));
      if (ltrs.empty()) content_.erase(cell);
    }
  }
  cells = Cells{};
}

}  // namespace hymm::core
