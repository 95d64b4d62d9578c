#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace hymm::core {

/// An observed point.
struct ArmPoint {
  Eigen::Vector2d arm = Eigen::Vector2d::Zero();  ///< from where all of them are turned about
  std::size_t deviation = 0;                      ///< number of its class of accuracy
};

/// Points near to each other, a range of all of them.
struct PointGroup {
  std::size_t begin = 0, end = 0;
  Eigen::Vector2d arm = Eigen::Vector2d::Zero();  ///< of its middle
  double within_m = 0.0;                          ///< of the middle are all its points
  double longest_m = 0.0;                         ///< arm of one of its points
  bool is_of_one_class = true;

  std::size_t size() const { return end - begin; }
};

/// Points, divided in halves again and again.
class PointTree {
 public:
  /// Brings `points`, one at least, into the order in which groups are ranges.
  explicit PointTree(std::vector<ArmPoint>& points);

  /// The largest groups that are accepted; those of one class at one place always are. Each point
  /// is in one of them. The heaviest first.
  std::vector<PointGroup> cut(const std::function<bool(const PointGroup&)>& is_accepted) const;

 private:
  struct Node {
    PointGroup group;
    std::size_t first = 0, second = 0;  ///< halves; 0: none
  };

  std::size_t divide(std::vector<ArmPoint>& points, std::size_t begin, std::size_t end);

  std::vector<Node> nodes_;  ///< from the root on
};

}  // namespace hymm::core
