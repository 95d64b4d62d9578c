#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "hybrid_map/ltr_partition.h"
#include "landmark_maps.h"

namespace hymm::core {

inline std::vector<int> aliveLtrs(const LtrMesh& mesh) {
  std::vector<int> alive;
  for (int i = 0; i < mesh.ltrEnd(); ++i) {
    if (mesh.ltr(i).is_alive) alive.push_back(i);
  }
  return alive;
}

inline std::set<int> landmarksOf(const LtrMesh& mesh, int ltr) {
  std::set<int> ids;
  for (const int v : mesh.ltr(ltr).vertices) ids.insert(mesh.vertex(v).landmark_id);
  return ids;
}

/// Area [m^2] of what two triangles have in common, by clipping: independent of overlap().
inline double commonArea(const Corners& a, const Corners& b) {
  std::vector<Eigen::Vector2d> polygon(a.begin(), a.end());
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<Eigen::Vector2d> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double dp = turn(b[k], b[(k + 1) % 3], p), dq = turn(b[k], b[(k + 1) % 3], q);
      if (dp >= 0) kept.push_back(p);
      if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) kept.push_back(p + dp / (dp - dq) * (q - p));
    }
    polygon = kept;
  }
  double twice = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    twice += turn(polygon[0], polygon[i - 1], polygon[i]);
  }
  return 0.5 * twice;
}

/// Everything that is promised of a partition over the landmarks of `map`; what is wrong, or "".
inline std::string brokenInvariant(const LtrPartition& partition, const LandmarkMap& map) {
  const LtrMesh& mesh = partition.mesh();
  std::map<int, Eigen::Vector2d> places;
  for (const auto& landmark : map.landmarks) places[landmark.id] = landmark.position;
  std::set<std::pair<int, int>> sides;
  std::set<int> pinned;
  const std::vector<int> alive = aliveLtrs(mesh);
  if (alive.size() != mesh.aliveCount()) return "the count of LTRs is wrong";
  for (const int i : alive) {
    const Ltr& ltr = mesh.ltr(i);
    const Corners corners = mesh.corners(i);
    if (turn(corners[0], corners[1], corners[2]) <= 0) return "an LTR is not counter-clockwise";
    for (std::size_t k = 0; k < 3; ++k) {
      const int id = mesh.vertex(ltr.vertices[k]).landmark_id;
      if (places.count(id) == 0) return "a vertex is no landmark";
      if ((corners[k] - places[id]).norm() > 0) return "a vertex is not where its landmark is";
      if ((ltr.triangle.vertex(int(k)) - corners[k]).norm() > 1e-9) return "the geometry is old";
      pinned.insert(id);
      const int from = ltr.vertices[k], to = ltr.vertices[(k + 1) % 3];
      if (!sides.emplace(from, to).second) return "a side bounds two LTRs on one side of it";
      if (ltr.neighbours[k] == kNone) continue;
      const Ltr& neighbour = mesh.ltr(ltr.neighbours[k]);
      bool is_mutual = false;
      for (std::size_t j = 0; j < 3; ++j) {
        is_mutual = is_mutual || (neighbour.neighbours[j] == i && neighbour.vertices[j] == to &&
                                  neighbour.vertices[(j + 1) % 3] == from);
      }
      if (!neighbour.is_alive || !is_mutual) return "neighbours do not agree on their side";
    }
  }
  for (const int i : alive) {
    const Ltr& ltr = mesh.ltr(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const bool has_twin = sides.count({ltr.vertices[(k + 1) % 3], ltr.vertices[k]}) > 0;
      if (has_twin != (ltr.neighbours[k] != kNone)) return "a shared side is not known as shared";
    }
    for (const int j : alive) {
      if (i < j && commonArea(mesh.corners(i), mesh.corners(j)) > 1e-9) return "LTRs overlap";
    }
  }
  const std::vector<int> told = partition.pinnedLandmarks();
  if (!std::equal(told.begin(), told.end(), pinned.begin(), pinned.end())) {
    return "pinned landmarks are not those that are vertices";
  }
  return "";
}

inline LtrPartition partitionOf(const LandmarkMap& map) {
  LtrPartition partition{PartitionConfig{}};
  partition.apply(map);
  return partition;
}

}  // namespace hymm::core
