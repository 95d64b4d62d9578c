#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace hymm::benchmarks {

/// The peer: A* on a square grid with eight neighbours and the octile distance as bound. Labels of
/// former queries are told apart by a number, so that nothing is cleared between queries.
class GridAStar {
 public:
  /// `cells` a side; all free.
  GridAStar(int cells, double resolution_m);

  void block(int x, int y) { blocked_[indexOf(x, y)] = 1; }

  /// Length of the way [m], or infinity.
  double find(const Eigen::Vector2d& start, const Eigen::Vector2d& goal);

 private:
  struct Label {
    float cost = 0.0F;
    std::uint32_t query = 0;
  };
  std::size_t indexOf(int x, int y) const {
    return std::size_t(y) * std::size_t(cells_) + std::size_t(x);
  }

  int cells_;
  double resolution_m_;
  std::vector<std::uint8_t> blocked_;
  std::vector<Label> labels_;
  std::uint32_t query_ = 0;
  std::vector<std::pair<float, std::uint32_t>> queue_;
};

}  // namespace hymm::benchmarks
