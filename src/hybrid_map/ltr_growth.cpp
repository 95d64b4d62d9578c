#include "hybrid_map/ltr_growth.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace hymm::core {
namespace {

// Among more landmarks than this, the nearest ones are enough to make LTRs of.
constexpr std::size_t kMaxNeighbours = 24;

/// Puts first the corner whose angle is nearest to a right one: the cells of a grid along the two
/// sides that meet there are then as square as can be.
std::array<int, 3> startingAtRightAngle(const std::array<int, 3>& order, const Corners& corners) {
  std::size_t best = 0;
  double best_sine = -1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d a = corners[(i + 1) % 3] - corners[i];
    const Eigen::Vector2d b = corners[(i + 2) % 3] - corners[i];
    const double sine = std::abs(a.x() * b.y() - a.y() * b.x()) / (a.norm() * b.norm());
    if (sine > best_sine) {
      best_sine = sine;
      best = i;
    }
  }
  return {order[best], order[(best + 1) % 3], order[(best + 2) % 3]};
}

}  // namespace

bool LtrGrowth::Candidate::operator<(const Candidate& other) const {
  return std::make_tuple(is_thin, landmarks_in_circle, -smallest_angle_rad, landmarks) <
         std::make_tuple(other.is_thin, other.landmarks_in_circle, -other.smallest_angle_rad,
                         other.landmarks);
}

LtrGrowth::LtrGrowth(const PartitionConfig& config, const LandmarkMap& map, LtrMesh& mesh)
    : config_(config), map_(map), mesh_(mesh) {
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (map.landmarks[i].observations < config.min_observations) continue;
    index_.place(static_cast<int>(i), map.landmarks[i].position);
  }
}

/// Whether an LTR could still have this landmark as a vertex: those inside an LTR are left out, and
/// around an inner vertex there is no room.
bool LtrGrowth::canSpan(int landmark) const {
  const LandmarkEstimate& estimate = map_.landmarks[std::size_t(landmark)];
  if (estimate.observations < config_.min_observations) return false;
  const int vertex = mesh_.findVertex(estimate.id);
  if (vertex != kNone) return mesh_.vertex(vertex).is_on_rim;
  return mesh_.locate(estimate.position) == kNone;
}

/// Of the landmarks in reach of the seeds the vertices that are there, and by age all others that
/// are no nearer to one of these, and to each other, than min_side_m. In a dense stand there is one
/// in any circle of that radius, so that their Delaunay triangles have sides of one to two times
/// min_side_m and no angle below 30 degrees. Triangles of whatever landmarks are far enough apart
/// seldom have sides in common, and block each other.
LtrGrowth::Subset LtrGrowth::standingApart(const std::vector<int>& seeds) const {
  Subset in_reach(map_.landmarks.size(), false), subset = in_reach;
  for (const int seed : seeds) {
    for (const int other :
         index_.near(map_.landmarks[std::size_t(seed)].position, config_.max_side_m)) {
      in_reach[std::size_t(other)] = true;
    }
  }
  LandmarkIndex taken;
  const auto hasRoom = [&](const Eigen::Vector2d& place) {
    const std::vector<int> near = taken.near(place, config_.min_side_m);
    return std::none_of(near.begin(), near.end(), [&](int other) {
      return (map_.landmarks[std::size_t(other)].position - place).norm() < config_.min_side_m;
    });
  };
  for (const bool takes_vertices : {true, false}) {
    for (std::size_t i = 0; i < map_.landmarks.size(); ++i) {
      const LandmarkEstimate& landmark = map_.landmarks[i];
      const bool is_vertex = mesh_.findVertex(landmark.id) != kNone;
      if (!in_reach[i] || is_vertex != takes_vertices || !canSpan(static_cast<int>(i))) continue;
      if (!is_vertex && !hasRoom(landmark.position)) continue;
      subset[i] = true;
      taken.place(static_cast<int>(i), landmark.position);
    }
  }
  return subset;
}

std::vector<int> LtrGrowth::neighboursOf(int seed, const Subset& subset) const {
  const Eigen::Vector2d& centre = map_.landmarks[std::size_t(seed)].position;
  std::vector<std::pair<double, int>> near;
  for (const int other : index_.near(centre, config_.max_side_m)) {
    const double distance = (map_.landmarks[std::size_t(other)].position - centre).norm();
    const bool is_near = other != seed && distance <= config_.max_side_m;
    if (is_near && subset[std::size_t(other)] && canSpan(other)) {
      near.emplace_back(distance, other);
    }
  }
  std::sort(near.begin(), near.end());
  near.resize(std::min(near.size(), kMaxNeighbours));
  std::vector<int> neighbours;
  neighbours.reserve(near.size());
  for (const auto& [distance, other] : near) neighbours.push_back(other);
  return neighbours;
}

Corners LtrGrowth::cornersOf(const std::array<int, 3>& landmarks) const {
  return {map_.landmarks[std::size_t(landmarks[0])].position,
          map_.landmarks[std::size_t(landmarks[1])].position,
          map_.landmarks[std::size_t(landmarks[2])].position};
}

std::optional<LtrGrowth::Candidate> LtrGrowth::candidateOf(
    const std::array<int, 3>& landmarks, const std::vector<int>& neighbours) const {
  Candidate candidate{landmarks, false, 0, 0.0};
  std::array<int, 3>& order = candidate.landmarks;
  const Corners given = cornersOf(order);
  if (turn(given[0], given[1], given[2]) < 0.0) std::swap(order[1], order[2]);
  std::rotate(order.begin(), std::min_element(order.begin(), order.end()), order.end());
  const Corners corners = cornersOf(order);
  candidate.smallest_angle_rad = smallestAngle(corners);
  // The comparisons are such that corners on one line fail them.
  candidate.is_thin = candidate.smallest_angle_rad < config_.min_angle_rad;
  const bool has_shape = smallestHeight(corners) >= config_.min_gap_height_m &&
                         shortestSide(corners) >= config_.min_side_m &&
                         longestSide(corners) <= config_.max_side_m;
  if (!has_shape) return std::nullopt;
  for (const int other : neighbours) {
    if (std::find(order.begin(), order.end(), other) != order.end()) continue;
    const Eigen::Vector2d& place = map_.landmarks[std::size_t(other)].position;
    if (isInsideCircumcircle(corners, place)) ++candidate.landmarks_in_circle;
  }
  return candidate;
}

void LtrGrowth::addCandidates(int seed, const std::vector<int>& neighbours,
                              std::vector<Candidate>& candidates) const {
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    for (std::size_t j = i + 1; j < neighbours.size(); ++j) {
      if (auto candidate = candidateOf({seed, neighbours[i], neighbours[j]}, neighbours)) {
        candidates.push_back(*candidate);
      }
    }
  }
}

/// Whether no vertex of one triangle is nearer to a side of the other than the clearance.
bool LtrGrowth::keepsClear(const Corners& corners, const std::array<int, 3>& vertices,
                           int other) const {
  const Corners other_corners = mesh_.corners(other);
  const std::array<int, 3>& other_vertices = mesh_.ltr(other).vertices;
  const auto isClear = [&](const Corners& a, const std::array<int, 3>& a_vertices, const Corners& b,
                           const std::array<int, 3>& b_vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      const bool is_shared =
          a_vertices[i] != kNone &&
          std::find(b_vertices.begin(), b_vertices.end(), a_vertices[i]) != b_vertices.end();
      for (std::size_t k = 0; k < 3 && !is_shared; ++k) {
        if (distanceToSegment(a[i], b[k], b[(k + 1) % 3]) < config_.clearance_m) return false;
      }
    }
    return true;
  };
  return isClear(corners, vertices, other_corners, other_vertices) &&
         isClear(other_corners, other_vertices, corners, vertices);
}

int LtrGrowth::sharedSides(const std::array<int, 3>& vertices) const {
  int shared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const int from = vertices[k], to = vertices[(k + 1) % 3];
    if (from != kNone && to != kNone && mesh_.hasSide(to, from)) ++shared;
  }
  return shared;
}

bool LtrGrowth::fits(const Candidate& candidate) const {
  const std::array<int, 3>& landmarks = candidate.landmarks;
  const Corners corners = cornersOf(landmarks);
  std::array<int, 3> vertices{};
  for (std::size_t i = 0; i < 3; ++i) {
    vertices[i] = mesh_.findVertex(map_.landmarks[std::size_t(landmarks[i])].id);
  }
  if (candidate.is_thin && sharedSides(vertices) < 2) return false;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(config_.clearance_m);
  const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) - margin;
  const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) + margin;
  bool is_free = true;
  mesh_.index().visit(low, high, [&](int other) {
    is_free =
        is_free && !overlap(corners, mesh_.corners(other)) && keepsClear(corners, vertices, other);
  });
  return is_free;
}

bool LtrGrowth::shapeIsKnown(const std::array<int, 3>& landmarks,
                             const PairCovariances& pairs) const {
  const auto covariance = pairs.joint(landmarks);
  return covariance && shapeFactor(cornersOf(landmarks), *covariance) <= config_.max_shape_factor;
}

int LtrGrowth::attach(std::array<int, 3> landmarks) {
  landmarks = startingAtRightAngle(landmarks, cornersOf(landmarks));
  std::array<int, 3> vertices{};
  for (std::size_t i = 0; i < 3; ++i) {
    const LandmarkEstimate& estimate = map_.landmarks[std::size_t(landmarks[i])];
    vertices[i] = mesh_.addVertex(estimate.id, estimate.position);
  }
  return mesh_.attach(vertices);
}

std::vector<int> LtrGrowth::growAround(const std::vector<int>& seeds) {
  const Subset subset = standingApart(seeds);
  std::vector<Candidate> candidates;
  std::unordered_set<int> ids;
  for (const int seed : seeds) {
    if (!subset[std::size_t(seed)] || !canSpan(seed)) continue;
    const std::vector<int> neighbours = neighboursOf(seed, subset);
    addCandidates(seed, neighbours, candidates);
    ids.insert(map_.landmarks[std::size_t(seed)].id);
    for (const int other : neighbours) ids.insert(map_.landmarks[std::size_t(other)].id);
  }
  std::sort(candidates.begin(), candidates.end());
  const PairCovariances pairs(map_, ids);
  std::vector<int> created;
  std::set<std::array<int, 3>> tried;  // a triangle is a candidate of each of its corners
  for (const Candidate& candidate : candidates) {
    if (!tried.insert(candidate.landmarks).second) continue;
    if (!fits(candidate) || !shapeIsKnown(candidate.landmarks, pairs)) continue;
    created.push_back(attach(candidate.landmarks));
  }
  return created;
}

}  // namespace hymm::core
