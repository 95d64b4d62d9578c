#include "hybrid_map/ltr_partition.h"

#include <algorithm>
#include <limits>

#include "hybrid_map/ltr_growth.h"

namespace hymm::core {
namespace {

// Cells of half the longest side: an LTR's box seldom touches more than four.
constexpr double kIndexCellShare = 0.5;

const LandmarkEstimate* find(const std::vector<LandmarkEstimate>& landmarks, int id) {
  const auto found = std::lower_bound(
      landmarks.begin(), landmarks.end(), id,
      [](const LandmarkEstimate& landmark, int wanted) { return landmark.id < wanted; });
  return found != landmarks.end() && found->id == id ? &*found : nullptr;
}

}  // namespace

LtrPartition::LtrPartition(const PartitionConfig& config)
    : config_(config), mesh_(kIndexCellShare * config.max_side_m) {}

PartitionChange LtrPartition::apply(const LandmarkMap& map) {
  PartitionChange change;
  mergeVertices(map.merges, map.landmarks, change);
  moveVertices(map.landmarks);
  loseUnseenVertices();
  correct(change);
  change.created = grow(map).created;
  return change;
}

PartitionChange LtrPartition::apply(const LandmarkUpdate& update) {
  PartitionChange change;
  mergeVertices(update.merges, update.changed, change);
  moveVertices(update.changed);
  for (const int id : update.removed_ids) loseVertex(mesh_.findVertex(id));
  correct(change);
  return change;
}

void LtrPartition::touch(int vertex) {
  for (const int ltr : mesh_.vertex(vertex).ltrs) {
    if (is_touched_.size() <= std::size_t(ltr)) is_touched_.resize(std::size_t(ltr) + 1, false);
    if (is_touched_[std::size_t(ltr)]) continue;
    is_touched_[std::size_t(ltr)] = true;
    touched_.push_back(ltr);
  }
}

void LtrPartition::moveVertices(const std::vector<LandmarkEstimate>& landmarks) {
  ++epoch_;
  seen_epoch_.resize(std::size_t(mesh_.vertexEnd()), 0);
  for (const LandmarkEstimate& landmark : landmarks) {
    const int vertex = mesh_.findVertex(landmark.id);
    if (vertex == kNone) continue;
    seen_epoch_[std::size_t(vertex)] = epoch_;
    if (mesh_.vertex(vertex).position == landmark.position) continue;
    mesh_.moveVertex(vertex, landmark.position);
    touch(vertex);
  }
}

// A landmark that was merged into another is a vertex under its name from now on, where the LTRs
// around allow it; its LTRs go through the same checks as after any correction.
void LtrPartition::mergeVertices(const std::vector<LandmarkMerge>& merges,
                                 const std::vector<LandmarkEstimate>& landmarks,
                                 PartitionChange& change) {
  for (const LandmarkMerge& merge : merges) {
    const int from = mesh_.findVertex(merge.from_id);
    if (from == kNone || merge.from_id == merge.into_id) continue;
    // Until `into` itself is merged, or told, it stands where `from` stood.
    const LandmarkEstimate* known = find(landmarks, merge.into_id);
    const Eigen::Vector2d place = known ? known->position : mesh_.vertex(from).position;
    const int into = mesh_.addVertex(merge.into_id, place);
    const std::vector<int> spanned = mesh_.vertex(from).ltrs;
    for (const int ltr : spanned) {
      if (!mesh_.exchangeVertex(ltr, from, into)) retire(ltr, RetiredLtr::Reason::kMerge, change);
    }
    touch(into);
    mesh_.forgetIfUnused(into);
  }
}

void LtrPartition::loseVertex(int vertex) {
  if (vertex == kNone) return;
  gone_.insert(vertex);
  touch(vertex);
}

void LtrPartition::loseUnseenVertices() {
  for (int vertex = 0; vertex < mesh_.vertexEnd(); ++vertex) {
    const bool is_used = !mesh_.vertex(vertex).ltrs.empty();
    if (is_used && seen_epoch_[std::size_t(vertex)] != epoch_) loseVertex(vertex);
  }
}

void LtrPartition::correct(PartitionChange& change) {
  retireMisshapen(change);
  retireOverlapping(change);
  for (const int ltr : touched_) {
    is_touched_[std::size_t(ltr)] = false;
    if (mesh_.ltr(ltr).is_alive) mesh_.commit(ltr);
  }
  touched_.clear();
  gone_.clear();
}

void LtrPartition::retireMisshapen(PartitionChange& change) {
  for (const int index : touched_) {
    const Ltr& ltr = mesh_.ltr(index);
    if (!ltr.is_alive) continue;
    const bool lost = std::any_of(ltr.vertices.begin(), ltr.vertices.end(),
                                  [&](int v) { return !gone_.empty() && gone_.count(v) > 0; });
    if (lost) {
      retire(index, RetiredLtr::Reason::kVertexGone, change);
      continue;
    }
    const Corners corners = mesh_.corners(index);
    Eigen::Matrix2d edges;
    edges << corners[1] - corners[0], corners[2] - corners[0];
    if (keepsShape(edges * ltr.created_inverse, config_.max_stretch)) {
      mesh_.placeInIndex(index);
    } else {
      retire(index, RetiredLtr::Reason::kShape, change);
    }
  }
}

// All LTRs being counter-clockwise, the number of LTRs over a point is the winding number of the
// partition's border around it. It can exceed one only where a border lies inside an LTR, and
// somewhere there an LTR that touches the border overlaps another. So only LTRs on the rim are
// compared with those around them. One that is retired puts its neighbours on the rim.
void LtrPartition::retireOverlapping(PartitionChange& change) {
  for (const int ltr : touched_) {
    if (mesh_.ltr(ltr).is_alive && mesh_.ltr(ltr).is_on_rim) overlap_suspects_.push_back(ltr);
  }
  while (!overlap_suspects_.empty()) {
    const int suspect = overlap_suspects_.back();
    overlap_suspects_.pop_back();
    while (mesh_.ltr(suspect).is_alive) {
      const int other = overlappingNeighbour(suspect);
      if (other == kNone) break;
      const double mine = mesh_.ltr(suspect).observations;
      const double theirs = mesh_.ltr(other).observations;
      // Of equals the older one stays.
      const bool suspect_goes = mine < theirs || (mine == theirs && suspect > other);
      retire(suspect_goes ? suspect : other, RetiredLtr::Reason::kOverlap, change);
    }
  }
}

int LtrPartition::overlappingNeighbour(int ltr) const {
  const Corners corners = mesh_.corners(ltr);
  const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  int found = kNone;
  mesh_.index().visit(low, high, [&](int other) {
    if (other != ltr && found == kNone && overlap(corners, mesh_.corners(other))) found = other;
  });
  return found;
}

void LtrPartition::retire(int index, RetiredLtr::Reason reason, PartitionChange& change) {
  const std::array<int, 3> vertices = mesh_.ltr(index).vertices;
  RetiredLtr retired;
  retired.ltr = index;
  retired.reason = reason;
  retired.last_valid = mesh_.ltr(index).triangle;
  std::array<double, 3> weights{};
  Corners before;
  for (std::size_t i = 0; i < 3; ++i) {
    weights[i] = gone_.count(vertices[i]) > 0 ? 0.0 : 1.0;
    before[i] = retired.last_valid.vertex(static_cast<int>(i));
    // What has room again may be tried again.
    tried_observations_.erase(mesh_.vertex(vertices[i]).landmark_id);
  }
  retired.T_map_last_valid = bestRigidFit(before, mesh_.corners(index), weights);
  mesh_.detach(index);
  change.retired.push_back(retired);
  for (const int vertex : vertices) {
    for (const int around : mesh_.vertex(vertex).ltrs) overlap_suspects_.push_back(around);
  }
}

bool LtrPartition::isWorthTrying(const LandmarkEstimate& landmark) const {
  if (landmark.observations < config_.min_observations) return false;
  const auto tried = tried_observations_.find(landmark.id);
  return tried == tried_observations_.end() || tried->second != landmark.observations;
}

PartitionChange LtrPartition::grow(const LandmarkMap& map) {
  PartitionChange change;
  std::vector<int> seeds;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (!isWorthTrying(map.landmarks[i])) continue;
    tried_observations_[map.landmarks[i].id] = map.landmarks[i].observations;
    seeds.push_back(static_cast<int>(i));
  }
  if (!seeds.empty()) change.created = LtrGrowth(config_, map, mesh_).growAround(seeds);
  return change;
}

}  // namespace hymm::core
