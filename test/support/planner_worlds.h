#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "door_planner/door_planner.h"
#include "support/planner_meshes.h"

namespace hymm::test {

/// Probability of a place in map.
using Occupancy = std::function<float(const Eigen::Vector2d&)>;

inline float freeGround(const Eigen::Vector2d&) { return 0.0F; }

/// Occupied within a vertical wall at x = 24 m but for a gap around `gap_y`.
inline Occupancy wallWithGap(double gap_y, double gap_m) {
  return [=](const Eigen::Vector2d& p) {
    return std::abs(p.x() - 24.0) < 0.3 && std::abs(p.y() - gap_y) > 0.5 * gap_m ? 1.0F : 0.0F;
  };
}

/// Discs at random, none within 2 m of `keep_free`.
inline Occupancy discs(std::uint64_t seed, int count, double extent_m,
                       std::vector<Eigen::Vector2d> keep_free) {
  core::RandomGenerator generator(seed);
  std::vector<Eigen::Vector3d> all;
  while (static_cast<int>(all.size()) < count) {
    const Eigen::Vector3d disc(core::sampleUniform(generator, 0.0, extent_m),
                               core::sampleUniform(generator, 0.0, extent_m),
                               core::sampleUniform(generator, 0.2, 2.0));
    const bool clear = std::all_of(
        keep_free.begin(), keep_free.end(),
        [&](const Eigen::Vector2d& p) { return (p - disc.head<2>()).norm() > disc.z() + 2.0; });
    if (clear) all.push_back(disc);
  }
  return [all](const Eigen::Vector2d& p) {
    return std::any_of(all.begin(), all.end(),
                       [&](const Eigen::Vector3d& disc) {
                         return (p - disc.head<2>()).squaredNorm() < disc.z() * disc.z();
                       })
               ? 1.0F
               : 0.0F;
  };
}

inline core::PlanRequest requestFor(const Eigen::Vector2d& start, const Eigen::Vector2d& goal) {
  core::PlanRequest request;
  request.start = start;
  request.goal = goal;
  return request;
}

/// A mesh of 4 x 4 squares of 12 m, jittered, with a planner that knows it.
struct PlannerWorld {
  SquareMesh mesh{4, 4, 12.0, 0.2, 2.0, 3};
  core::DoorPlanner planner;

  explicit PlannerWorld(const Occupancy& occupancy, const core::DoorPlannerConfig& config = {})
      : planner(config) {
    planner.setLtrs(mesh.ltrs);
    show(occupancy);
  }
  void show(const Occupancy& occupancy) {
    for (const core::LtrView& ltr : mesh.ltrs)
      planner.setContent(ltr.id, contentOf(ltr, occupancy));
    planner.prepare(Eigen::Vector2d::Zero());
  }
  core::Plan plan(const Eigen::Vector2d& start, const Eigen::Vector2d& goal) const {
    return planner.plan(requestFor(start, goal));
  }
};

/// Whether the path, at every centimetre, lies in a cell that is not occupied, and how near the
/// nearest obstacle of the world comes.
inline bool isFree(const std::vector<Eigen::Vector2d>& path, const Occupancy& occupancy) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int parts = static_cast<int>(std::ceil((path[i] - path[i - 1]).norm() / 0.01));
    for (int k = 0; k <= parts; ++k) {
      const Eigen::Vector2d p = path[i - 1] + (path[i] - path[i - 1]) * k / std::max(1, parts);
      if (occupancy(p) > 0.5F) return false;
    }
  }
  return true;
}

}  // namespace hymm::test
