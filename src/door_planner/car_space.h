#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/random.h"
#include "door_planner/car_curve.h"

namespace hymm::core {

/// Poses of a car that cannot turn tighter than a radius, after Reeds and Shepp, or, if it cannot
/// go backwards, Dubins; by OMPL.
class CarSpace {
 public:
  CarSpace(double turning_radius_m, bool can_reverse);
  ~CarSpace();

  double turningRadius_m() const { return turning_radius_m_; }

  /// The shortest way where nothing is in it. Without pieces if both poses are the same.
  CarCurve shortest(const Pose2& from, const Pose2& to) const;

  /// What search() is to find a way through.
  struct Maze {
    std::function<bool(const Pose2&)> is_free;
    std::function<Pose2(RandomGenerator&)> sample;
    Eigen::Vector2d low, high;  ///< around all of it, m
  };
  struct Effort {
    int iterations = 500;
    std::uint64_t seed = 1;
    std::function<bool()> stop;  ///< ends the search; may be empty
  };

  /// Poses from the start to one of the goals, each reached from the one before by shortest(), by
  /// RRT*: the best way that so many iterations find. The same effort finds the same.
  std::optional<std::vector<Pose2>> search(const Pose2& start, const std::vector<Pose2>& goals,
                                           const Maze& maze, const Effort& effort) const;

  struct Space;

 private:
  double turning_radius_m_;
  std::unique_ptr<Space> space_;
};

}  // namespace hymm::core
