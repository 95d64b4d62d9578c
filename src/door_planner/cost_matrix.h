#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "door_planner/local_search.h"

namespace hymm::core {

/// C_i (9): what it costs to go from one portal of an LTR to another inside it, and how. In general
/// not symmetric. C(j, l) <= C(j, k) + C(k, l).
class CostMatrix {
 public:
  CostMatrix() = default;
  /// Between `portals` (local coordinates), by searches inside the LTR.
  CostMatrix(LocalSearch& search, const std::vector<Triangle::Local>& portals, bool is_directed);

  int size() const { return size_; }
  /// Infinite where there is no way.
  float cost(int from, int to) const { return costs_[at(from, to)]; }
  /// A row of costs, to each portal in turn.
  const float* row(int from) const { return costs_.data() + std::ptrdiff_t{from} * size_; }

  /// Where the path turns between its ends, in local coordinates; nothing where there is no way.
  std::vector<Triangle::Local> turns(int from, int to) const;

  std::size_t bytes() const;

 private:
  /// Of turns_; of a path that runs back along another, `is_reversed`.
  struct Span {
    std::uint32_t begin = 0;
    std::uint16_t count = 0;
    bool is_reversed = false;
  };
  using Paths = std::vector<LocalPath>;

  std::size_t at(int from, int to) const {
    return std::size_t(from) * std::size_t(size_) + std::size_t(to);
  }
  Paths search(LocalSearch& search, const std::vector<Triangle::Local>& portals,
               bool is_directed) const;
  void close(Paths& paths) const;
  void keep(const Paths& paths);

  int size_ = 0;
  std::vector<float> costs_;
  std::vector<Span> spans_;
  std::vector<Eigen::Vector2f> turns_;
};

}  // namespace hymm::core
