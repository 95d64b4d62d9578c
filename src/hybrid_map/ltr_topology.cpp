#include "hybrid_map/ltr_topology.h"

#include <limits>
#include <unordered_map>

#include "hybrid_map/pair_covariances.h"

namespace hymm::core {
namespace {

/// Where landmarks stand in a map, by id.
using Places = std::unordered_map<int, int>;

double shapeFactorOf(const LtrTopology& ltr, const Corners& corners, const Places& places,
                     const PairCovariances& pairs) {
  std::array<int, 3> vertices{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = places.find(ltr.landmark_ids[i]);
    if (place == places.end()) return std::numeric_limits<double>::quiet_NaN();
    vertices[i] = place->second;
  }
  const auto covariance = pairs.joint(vertices);
  return covariance ? shapeFactor(corners, *covariance) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::vector<LtrTopology> topologyOf(const LtrPartition& partition, const LandmarkMap& map) {
  const std::vector<int> pinned = partition.pinnedLandmarks();
  const PairCovariances pairs(map, {pinned.begin(), pinned.end()});
  Places places;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    places[map.landmarks[i].id] = static_cast<int>(i);
  }
  std::vector<LtrTopology> topology;
  const LtrMesh& mesh = partition.mesh();
  for (int index = 0; index < mesh.ltrEnd(); ++index) {
    const Ltr& ltr = mesh.ltr(index);
    if (!ltr.is_alive) continue;
    LtrTopology described;
    described.id = index;
    for (std::size_t i = 0; i < 3; ++i) {
      described.landmark_ids[i] = mesh.vertex(ltr.vertices[i]).landmark_id;
    }
    described.neighbours = ltr.neighbours;
    described.observations = ltr.observations;
    described.shape_factor = shapeFactorOf(described, mesh.corners(index), places, pairs);
    topology.push_back(described);
  }
  return topology;
}

}  // namespace hymm::core
