#pragma once

#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

#include "door_planner/door_graph.h"

namespace hymm::core {

class PortalSearch;

/// What it costs to cross a district from one portal of its border to another without leaving it,
/// as LTRs' cost matrices and factors say (9), (19). Kept as long as these are the same.
class DistrictMatrix {
 public:
  /// Whatever of an LTR the costs depend on. A matrix is made anew whenever the LTR's portals or
  /// cells change.
  struct Source {
    int id = kNone;
    double factor = 1.0;
    std::shared_ptr<const CostMatrix> matrix;
    bool operator==(const Source& o) const {
      return id == o.id && factor == o.factor && matrix == o.matrix;
    }
  };

  DistrictMatrix(std::vector<Source> sources, int size)
      : sources_(std::move(sources)),
        size_(size),
        costs_(std::size_t(size) * std::size_t(size), 0.0F) {}

  const std::vector<Source>& sources() const { return sources_; }
  int size() const { return size_; }
  const float* row(int from) const { return costs_.data() + std::ptrdiff_t{from} * size_; }
  float* row(int from) { return costs_.data() + std::ptrdiff_t{from} * size_; }
  std::size_t bytes() const {
    return sizeof(*this) + costs_.capacity() * sizeof(float) + sources_.capacity() * sizeof(Source);
  }

 private:
  std::vector<Source> sources_;
  int size_ = 0;
  std::vector<float> costs_;
};

/// Which LTRs of a graph belong together, and the sides between those that do not.
class DistrictLayout {
 public:
  /// A side of an LTR of the district, beyond which another begins.
  struct Border {
    int side = kNone;
    std::size_t end = 0;   ///< of the side's LTRs, the one in the district
    int first_portal = 0;  ///< in a row of the matrix
    int portals = 0;
  };
  struct District {
    std::vector<int> ltrs;
    std::vector<Border> borders;
    int portals = 0;       ///< on them
    int first_portal = 0;  ///< among those on the borders of all districts
  };

  /// By squares of map. LTRs that have a place in `before` keep it, wherever they move.
  DistrictLayout(std::shared_ptr<const DoorGraph> graph, double edge_m,
                 const DistrictLayout* before);

  const std::shared_ptr<const DoorGraph>& graph() const { return graph_; }
  const std::vector<District>& districts() const { return districts_; }
  int districtOf(int ltr) const { return district_of_ltr_[std::size_t(ltr)]; }
  int rowOf(int side, std::size_t end) const { return rows_[std::size_t(side)][end]; }
  int borderPortals() const { return border_portals_; }
  /// The district of LTRs whose key this is; kNone if there is none now.
  int find(std::uint64_t key) const;
  std::uint64_t keyOf(int district) const { return keys_[std::size_t(district)]; }
  std::vector<DistrictMatrix::Source> sourcesOf(int district) const;
  std::size_t bytes() const;

 private:
  void findBorders();

  std::shared_ptr<const DoorGraph> graph_;
  std::vector<District> districts_;
  int border_portals_ = 0;
  std::vector<int> district_of_ltr_;
  std::vector<std::array<int, 2>> rows_;  ///< of a side's first portal, in the districts it borders
  std::vector<std::uint64_t> keys_;       ///< of the squares, by district
  std::unordered_map<std::uint64_t, int> by_key_;
  std::unordered_map<int, std::uint64_t> key_of_id_;  ///< by id of the LTR
};

/// The idea of doors and cost matrices applied once more: LTRs that lie together make a district,
/// and long ways cross it at once, from border to border. It changes no cost, only how many portals
/// a search takes up. Belongs to one graph and never changes, so that queries can share it.
class Districts {
 public:
  /// Takes over from `before` (may be null) what is still as it was.
  Districts(std::shared_ptr<const DoorGraph> graph, double edge_m, const Districts* before);

  /// The same with at most `max` of the missing matrices computed.
  Districts withMatrices(std::size_t max, PortalSearch& search) const;
  std::size_t missing() const;

  const std::shared_ptr<const DoorGraph>& graph() const { return layout_->graph(); }
  int districtOf(int ltr) const { return layout_->districtOf(ltr); }
  const DistrictLayout::District& district(int number) const {
    return layout_->districts()[std::size_t(number)];
  }
  /// On the borders of all districts, each counted in both that it lies between.
  int borderPortals() const { return layout_->borderPortals(); }
  /// Of a side's first portal, in the matrix of the district that holds its LTR `end`.
  int rowOf(int side, std::size_t end) const { return layout_->rowOf(side, end); }
  /// Null while it is not computed.
  const DistrictMatrix* matrix(int district) const {
    return matrices_[std::size_t(district)].get();
  }
  std::size_t count() const { return matrices_.size(); }
  std::size_t bytes() const;

 private:
  std::shared_ptr<const DistrictMatrix> compute(int district, PortalSearch& search) const;

  std::shared_ptr<const DistrictLayout> layout_;
  std::vector<std::shared_ptr<const DistrictMatrix>> matrices_;
};

}  // namespace hymm::core
