#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "simulation/solid.h"

namespace hymm::core {

/// Where a ray first meets something solid.
struct RayHit {
  double range_m = 0.0;
  double incidence_cosine = 1.0;  ///< between the ray and the surface's normal
  std::size_t solid = 0;          ///< index into the solids that were given
};

/// Meets rays with discs and polygons exactly, through a uniform grid over those solids. A ray
/// that starts inside a solid sees its far side.
class RayCaster {
 public:
  explicit RayCaster(const std::vector<Solid>& solids, double cell_m = 4.0);

  /// The nearest hit within `range_max_m` along the unit vector `direction`.
  std::optional<RayHit> cast(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                             double range_max_m) const;

 private:
  struct Edge {
    Eigen::Vector2d from, to;
  };
  /// A disc or one edge of a polygon.
  struct Surface {
    std::variant<Disc, Edge> form;
    std::size_t solid;
  };

  void addSurfaces(const Solid& solid, std::size_t index);
  void fillGrid();
  Eigen::Array2i cellOf(const Eigen::Vector2d& point) const;
  void meet(const Surface& surface, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
            std::optional<RayHit>& nearest, double& range_limit_m) const;

  double cell_m_;
  std::vector<Surface> surfaces_;
  Eigen::AlignedBox2d bounds_;
  Eigen::Array2i cells_ = Eigen::Array2i::Zero();
  std::vector<std::size_t> cell_begin_;     ///< into cell_surfaces_, one more than there are cells
  std::vector<std::size_t> cell_surfaces_;  ///< indices of surfaces_, cell after cell
};

}  // namespace hymm::core
