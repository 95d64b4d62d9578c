#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// Finds landmarks by place: a hash of square cells over the map frame.
class LandmarkIndex {
 public:
  /// Adds a slot, or moves it to `position` [m].
  void place(int slot, const Eigen::Vector2d& position);
  void remove(int slot);
  void clear();

  /// Slots in cells that a circle touches, ascending: all within `radius_m` of `centre`, and some
  /// beyond.
  std::vector<int> near(const Eigen::Vector2d& centre, double radius_m) const;

 private:
  using Key = std::int64_t;
  static constexpr double kCell_m = 4.0;

  static std::int32_t cellOf(double coordinate);
  static Key keyOf(std::int32_t x, std::int32_t y);

  std::unordered_map<Key, std::vector<int>> cells_;
  std::unordered_map<int, Key> key_of_slot_;
};

}  // namespace hymm::core
