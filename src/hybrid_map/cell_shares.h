#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "hybrid_map/cell_model.h"

namespace hymm::core {

/// A cell that moves to another grid is taken apart into equal parts, each of which goes to the
/// cell in which its centre falls; fewer parts would leave gaps between the cells that they reach.
/// Centres in units of the cell. The middle one comes first.
inline const std::array<Eigen::Vector2d, 9> kCellParts = {
    Eigen::Vector2d(0.5, 0.5),         Eigen::Vector2d(0.5, 1.0 / 6),
    Eigen::Vector2d(5.0 / 6, 1.0 / 6), Eigen::Vector2d(1.0 / 6, 0.5),
    Eigen::Vector2d(1.0 / 6, 1.0 / 6), Eigen::Vector2d(5.0 / 6, 0.5),
    Eigen::Vector2d(1.0 / 6, 5.0 / 6), Eigen::Vector2d(0.5, 5.0 / 6),
    Eigen::Vector2d(5.0 / 6, 5.0 / 6)};

/// Into how many of these a cell is taken apart: what is of one place stays whole, in the middle.
inline std::size_t partsOf(const CellModel& model, const float* cell) {
  return model.isOfOnePlace(cell) ? 1 : kCellParts.size();
}

inline bool hasEvidence(const float* cell, int channels) {
  return std::any_of(cell, cell + channels, [](float value) { return value != 0.0F; });
}

}  // namespace hymm::core
