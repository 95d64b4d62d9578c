#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Core>

namespace hymm::core {

/// A cell that moves to another grid is taken apart into equal parts, each of which goes to the
/// cell in which its centre falls; fewer parts would leave gaps between the cells that they reach.
/// Centres in units of the cell.
inline const std::array<Eigen::Vector2d, 9> kCellParts = {
    Eigen::Vector2d(1.0 / 6, 1.0 / 6), Eigen::Vector2d(0.5, 1.0 / 6),
    Eigen::Vector2d(5.0 / 6, 1.0 / 6), Eigen::Vector2d(1.0 / 6, 0.5),
    Eigen::Vector2d(0.5, 0.5),         Eigen::Vector2d(5.0 / 6, 0.5),
    Eigen::Vector2d(1.0 / 6, 5.0 / 6), Eigen::Vector2d(0.5, 5.0 / 6),
    Eigen::Vector2d(5.0 / 6, 5.0 / 6)};
constexpr float kCellPartShare = 1.0F / 9.0F;

inline bool hasEvidence(const float* cell, int channels) {
  return std::any_of(cell, cell + channels, [](float value) { return value != 0.0F; });
}

}  // namespace hymm::core
