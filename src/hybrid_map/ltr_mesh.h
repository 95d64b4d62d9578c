#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "hybrid_map/ltr_geometry.h"
#include "hybrid_map/ltr_index.h"
#include "hybrid_map/simplex.h"

namespace hymm::core {

/// No LTR, or no vertex.
constexpr int kNone = -1;

/// A local triangular region. Side k runs from vertex k to vertex k + 1 (modulo 3).
struct Ltr {
  bool is_alive = true;
  bool is_on_rim = true;          ///< whether one of its vertices lies on the partition's border
  std::array<int, 3> vertices{};  ///< of the mesh, counter-clockwise; the first is L_1 of (2)
  std::array<int, 3> neighbours{kNone, kNone, kNone};  ///< across each side
  Triangle triangle;                                   ///< the last geometry found valid; (2)-(6)
  Eigen::Matrix2d created_inverse =
      Eigen::Matrix2d::Zero();  ///< of the edges (2) when it was made, 1/m
  double observations = 0.0;    ///< evidence written so far

  template <class Archive>
  void describeState(Archive& archive) {
    archive(is_alive, is_on_rim, vertices, neighbours, triangle, created_inverse, observations);
  }
};

/// A landmark that spans LTRs.
struct MeshVertex {
  int landmark_id = -1;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in map, m
  std::vector<int> ltrs;                               ///< that it spans
  bool is_on_rim = true;

  template <class Archive>
  void describeState(Archive& archive) {
    archive(landmark_id, position, ltrs, is_on_rim);
  }
};

/// Triangles over vertices with their adjacency and places: two LTRs share a whole side, a vertex,
/// or nothing. An LTR's number is its identity and is not used again. Whether shapes are valid is
/// the partition's care: positions of vertices change first, `Ltr::triangle` follows by commit().
class LtrMesh {
 public:
  explicit LtrMesh(double index_cell_m) : index_(index_cell_m) {}

  int addVertex(int landmark_id, const Eigen::Vector2d& position);
  int findVertex(int landmark_id) const;
  const MeshVertex& vertex(int index) const { return vertices_[std::size_t(index)]; }
  void moveVertex(int index, const Eigen::Vector2d& position) {
    vertices_[std::size_t(index)].position = position;
  }
  /// Forgets a vertex that spans nothing.
  void forgetIfUnused(int vertex);
  /// One past the largest index of a vertex; those that span nothing are unused.
  int vertexEnd() const { return static_cast<int>(vertices_.size()); }
  std::size_t vertexCount() const { return vertex_of_landmark_.size(); }
  /// Ids of all landmarks that are vertices, ascending.
  std::vector<int> vertexLandmarks() const;

  /// Whether an LTR lies to the left of the side from one vertex to another.
  bool hasSide(int from, int to) const { return ltr_of_side_.count(sideKey(from, to)) > 0; }

  /// A new LTR over counter-clockwise vertices, its geometry valid; kNone if one of its sides
  /// already bounds an LTR on this side.
  int attach(const std::array<int, 3>& vertices);
  /// Puts `to` in the place of `from` as a vertex of an LTR; `from` is forgotten if it spans
  /// nothing any more. False, and nothing changed, if a side is taken or the LTR has both.
  bool exchangeVertex(int ltr, int from, int to);
  /// Takes an LTR out; vertices that span nothing any more are forgotten.
  void detach(int ltr);

  /// Brings the index to where the vertices are now.
  void placeInIndex(int ltr);
  /// Makes the geometry of the present vertices the valid one.
  void commit(int ltr) { ltrs_[std::size_t(ltr)].triangle = Triangle(corners(ltr)); }

  const Ltr& ltr(int index) const { return ltrs_[std::size_t(index)]; }
  void addObservations(int ltr, double count) { ltrs_[std::size_t(ltr)].observations += count; }
  /// One past the largest number of an LTR, dead ones included.
  int ltrEnd() const { return static_cast<int>(ltrs_.size()); }
  std::size_t aliveCount() const { return alive_; }

  /// Corners where the vertices are now.
  Corners corners(int ltr) const;

  /// An LTR that contains the point, borders included, or kNone. Walks from `hint` towards the
  /// point; where that leaves the mesh, or is far, the index answers.
  int locate(const Eigen::Vector2d& point, int hint = kNone) const;

  const LtrIndex& index() const { return index_; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(ltrs_, vertices_, free_vertices_, vertex_of_landmark_, ltr_of_side_, index_);
    if constexpr (Archive::kReads) {
      archive.require(countAlive() && index_.isBelow(ltrEnd()),
                      "its triangles contradict each other");
    }
  }

 private:
  /// Counts the LTRs; false if one of them, or a vertex, refers to what is not there.
  bool countAlive();

  static std::uint64_t sideKey(int from, int to) {
    return static_cast<std::uint64_t>(from) << 32U | static_cast<std::uint32_t>(to);
  }
  bool sidesAreFree(const std::array<int, 3>& vertices) const;
  void connect(int ltr);
  void disconnect(int ltr);
  void refreshRim(const std::array<int, 3>& vertices);
  bool spansBorder(int vertex) const;
  int walk(const Eigen::Vector2d& point, int from) const;

  std::vector<Ltr> ltrs_;
  std::vector<MeshVertex> vertices_;
  std::vector<int> free_vertices_;
  std::unordered_map<int, int> vertex_of_landmark_;
  std::unordered_map<std::uint64_t, int> ltr_of_side_;  ///< by directed side
  LtrIndex index_;
  std::size_t alive_ = 0;
};

}  // namespace hymm::core
