#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "hybrid_map/ltr_geometry.h"
#include "hybrid_map/ltr_topology.h"
#include "scene/texture_atlas.h"

/// LTRs as triangles with textures. Where a texture lies on its triangle is fixed for good; where
/// the triangle lies, its landmarks tell.
namespace hymm::core {

/// Where the landmark is; nothing if it is not in the map.
std::optional<Eigen::Vector2d> findPosition(const LandmarkMap& map, int id);

/// Corners of an LTR; nothing if one of its landmarks is not in the map.
std::optional<Corners> findCorners(const LandmarkMap& map, const LtrTopology& ltr);

/// Texture coordinates of the vertices L1, L2, L3 on a page of `page_size` pixels, of an image with
/// a rim of one pixel (LayerImage): the cell (i, j) lies at (1 + i, 1 + j) in it.
std::array<Eigen::Vector2f, 3> textureCorners(const AtlasPlace& place, int page_size);

/// Each side of the LTRs once: ids of its landmarks, the smaller one first.
std::vector<std::pair<int, int>> sidesOf(const std::vector<LtrTopology>& ltrs);

/// The two triangles of a straight line `width_m` wide.
std::array<Eigen::Vector2d, 6> wideLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                        double width_m);

}  // namespace hymm::core
