#include "hybrid_map/ltr_mesh.h"

#include <algorithm>

#include "hybrid_map/input_check.h"

namespace hymm::core {

int LtrMesh::addVertex(int landmark_id, const Eigen::Vector2d& position) {
  const int known = findVertex(landmark_id);
  if (known != kNone) return known;
  int index = static_cast<int>(vertices_.size());
  if (free_vertices_.empty()) {
    vertices_.emplace_back();
  } else {
    index = free_vertices_.back();
    free_vertices_.pop_back();
  }
  MeshVertex& vertex = vertices_[std::size_t(index)];
  vertex.landmark_id = landmark_id;
  vertex.position = position;
  vertex.is_on_rim = true;
  vertex_of_landmark_[landmark_id] = index;
  return index;
}

int LtrMesh::findVertex(int landmark_id) const {
  const auto found = vertex_of_landmark_.find(landmark_id);
  return found == vertex_of_landmark_.end() ? kNone : found->second;
}

std::vector<int> LtrMesh::vertexLandmarks() const {
  std::vector<int> ids;
  ids.reserve(vertex_of_landmark_.size());
  for (const auto& [id, vertex] : vertex_of_landmark_) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

bool LtrMesh::sidesAreFree(const std::array<int, 3>& vertices) const {
  for (std::size_t k = 0; k < 3; ++k) {
    if (ltr_of_side_.count(sideKey(vertices[k], vertices[(k + 1) % 3])) > 0) return false;
  }
  return true;
}

int LtrMesh::attach(const std::array<int, 3>& vertices) {
  if (!sidesAreFree(vertices)) return kNone;
  const int ltr = static_cast<int>(ltrs_.size());
  ltrs_.emplace_back();
  ltrs_.back().vertices = vertices;
  connect(ltr);
  commit(ltr);
  ltrs_.back().created_inverse = ltrs_.back().triangle.edgesInverse();
  placeInIndex(ltr);
  ++alive_;
  return ltr;
}

void LtrMesh::connect(int index) {
  Ltr& ltr = ltrs_[std::size_t(index)];
  for (std::size_t k = 0; k < 3; ++k) {
    const int from = ltr.vertices[k], to = ltr.vertices[(k + 1) % 3];
    ltr_of_side_[sideKey(from, to)] = index;
    vertices_[std::size_t(from)].ltrs.push_back(index);
    const auto opposite = ltr_of_side_.find(sideKey(to, from));
    ltr.neighbours[k] = opposite == ltr_of_side_.end() ? kNone : opposite->second;
    if (ltr.neighbours[k] == kNone) continue;
    Ltr& neighbour = ltrs_[std::size_t(ltr.neighbours[k])];
    for (std::size_t j = 0; j < 3; ++j) {
      if (neighbour.vertices[j] == to) neighbour.neighbours[j] = index;
    }
  }
  refreshRim(ltr.vertices);
}

void LtrMesh::disconnect(int index) {
  Ltr& ltr = ltrs_[std::size_t(index)];
  for (std::size_t k = 0; k < 3; ++k) {
    const int from = ltr.vertices[k], to = ltr.vertices[(k + 1) % 3];
    ltr_of_side_.erase(sideKey(from, to));
    std::vector<int>& spanned = vertices_[std::size_t(from)].ltrs;
    spanned.erase(std::find(spanned.begin(), spanned.end(), index));
    if (ltr.neighbours[k] == kNone) continue;
    for (int& back : ltrs_[std::size_t(ltr.neighbours[k])].neighbours) {
      if (back == index) back = kNone;
    }
    ltr.neighbours[k] = kNone;
  }
  refreshRim(ltr.vertices);
}

bool LtrMesh::spansBorder(int vertex) const {
  for (const int index : vertices_[std::size_t(vertex)].ltrs) {
    const Ltr& ltr = ltrs_[std::size_t(index)];
    for (std::size_t k = 0; k < 3; ++k) {
      const bool touches = ltr.vertices[k] == vertex || ltr.vertices[(k + 1) % 3] == vertex;
      if (touches && ltr.neighbours[k] == kNone) return true;
    }
  }
  return false;
}

// A side with a neighbour less or more changes its two vertices, and these all LTRs around them.
void LtrMesh::refreshRim(const std::array<int, 3>& vertices) {
  for (const int vertex : vertices) vertices_[std::size_t(vertex)].is_on_rim = spansBorder(vertex);
  for (const int vertex : vertices) {
    for (const int index : vertices_[std::size_t(vertex)].ltrs) {
      Ltr& ltr = ltrs_[std::size_t(index)];
      ltr.is_on_rim = std::any_of(ltr.vertices.begin(), ltr.vertices.end(),
                                  [&](int v) { return vertices_[std::size_t(v)].is_on_rim; });
    }
  }
}

bool LtrMesh::exchangeVertex(int index, int from, int to) {
  Ltr& ltr = ltrs_[std::size_t(index)];
  std::array<int, 3> exchanged = ltr.vertices;
  if (std::find(exchanged.begin(), exchanged.end(), to) != exchanged.end()) return false;
  std::replace(exchanged.begin(), exchanged.end(), from, to);
  for (std::size_t k = 0; k < 3; ++k) {
    const int a = exchanged[k], b = exchanged[(k + 1) % 3];
    if ((a == to || b == to) && ltr_of_side_.count(sideKey(a, b)) > 0) return false;
  }
  disconnect(index);
  ltr.vertices = exchanged;
  connect(index);
  forgetIfUnused(from);
  return true;
}

void LtrMesh::detach(int index) {
  Ltr& ltr = ltrs_[std::size_t(index)];
  disconnect(index);
  index_.remove(index);
  ltr.is_alive = false;
  --alive_;
  for (const int vertex : ltr.vertices) forgetIfUnused(vertex);
}

void LtrMesh::forgetIfUnused(int index) {
  MeshVertex& vertex = vertices_[std::size_t(index)];
  if (!vertex.ltrs.empty() || vertex.landmark_id < 0) return;
  vertex_of_landmark_.erase(vertex.landmark_id);
  vertex.landmark_id = -1;
  free_vertices_.push_back(index);
}

Corners LtrMesh::corners(int index) const {
  const std::array<int, 3>& v = ltrs_[std::size_t(index)].vertices;
  return {vertices_[std::size_t(v[0])].position, vertices_[std::size_t(v[1])].position,
          vertices_[std::size_t(v[2])].position};
}

void LtrMesh::placeInIndex(int ltr) {
  const Corners c = corners(ltr);
  index_.place(ltr, c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2]));
}

int LtrMesh::walk(const Eigen::Vector2d& point, int from) const {
  constexpr int kMaxSteps = 16;
  int index = from;
  for (int step = 0; step < kMaxSteps && index != kNone; ++step) {
    const Ltr& here = ltrs_[std::size_t(index)];
    const Triangle::Weights weights = Triangle::weights(here.triangle.toLocal(point));
    int least = 0;
    if (weights.minCoeff(&least) >= -kBorderTolerance) return index;
    index = here.neighbours[std::size_t(least + 1) % 3];  // across the side opposite that vertex
  }
  return kNone;
}

int LtrMesh::locate(const Eigen::Vector2d& point, int hint) const {
  if (!isPlace(point)) return kNone;
  if (hint >= 0 && hint < ltrEnd() && ltrs_[std::size_t(hint)].is_alive) {
    const int reached = walk(point, hint);
    if (reached != kNone) return reached;
  }
  int found = kNone;
  index_.visit(point, point, [&](int ltr) {
    const bool is_least = found == kNone || ltr < found;
    if (is_least && ltrs_[std::size_t(ltr)].triangle.contains(point)) found = ltr;
  });
  return found;
}

}  // namespace hymm::core
