#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "door_planner/cell_costs.h"
#include "door_planner/cost_matrix.h"
#include "door_planner/side_doors.h"
#include "hybrid_map/simplex.h"

namespace hymm::core {

/// An LTR with all that a query needs of it. LTRs, sides and portals are numbered within the graph.
struct GraphLtr {
  LtrView view;
  Triangle triangle;
  double factor = 1.0;   ///< K of (19)
  double stretch = 1.0;  ///< by which lengths have grown, at most, since costs were computed
  std::array<int, 3> neighbours{kNone, kNone, kNone};  ///< across each side
  std::array<int, 3> sides{kNone, kNone, kNone};
  std::array<int, 4> first_portal{};         ///< of each side among those of the LTR, and the end
  std::shared_ptr<const CellCosts> costs;    ///< null while nothing of it is known
  std::shared_ptr<const CostMatrix> matrix;  ///< null while it is not computed
};

/// A side between two LTRs.
struct GraphSide {
  std::array<int, 2> ltrs{kNone, kNone};
  int first_portal = 0, portals = 0;
  std::shared_ptr<const SideDoors> doors;
};

/// What an LTR holds now, of a number in the graph.
struct GraphChange {
  int ltr = kNone;
  double stretch = 1.0;
  std::shared_ptr<const CellCosts> costs;
  std::shared_ptr<const CostMatrix> matrix;
};

/// What a search reads of an LTR, together and small: searches are as fast as memory is.
struct SearchLtr {
  const float* costs = nullptr;  ///< rows of its matrix; null without one
  float factor = 1.0F;
  int size = 0;  ///< of a row
  std::array<int, 3> sides{kNone, kNone, kNone};
  std::array<std::uint16_t, 4> first_portal{};  ///< of a side in a row
};

/// And of a side: its portals in the graph, its LTRs, and where its portals stand in their rows.
struct SearchSide {
  int first_portal = 0, portals = 0;
  std::array<int, 2> ltrs{kNone, kNone};
  std::array<std::uint16_t, 2> index{};
  int crossing = kNone;  ///< of its first portal among the graph's crossings
};

/// A place in an LTR, by its number in the graph.
struct GraphPlace {
  int ltr = kNone;
  Triangle::Local local = Triangle::Local::Zero();
};

/// Doors, cost matrices and geometry at one moment. Never changes, so that queries can share it.
class DoorGraph {
 public:
  DoorGraph() = default;
  /// Portals and places follow from LTRs and sides.
  DoorGraph(std::vector<GraphLtr> ltrs, std::vector<GraphSide> sides, double max_metric_error);

  const std::vector<GraphLtr>& ltrs() const { return ltrs_; }
  const GraphLtr& ltr(int number) const { return ltrs_[std::size_t(number)]; }
  const std::vector<GraphSide>& sides() const { return frame_->sides; }
  const GraphSide& side(int number) const { return frame_->sides[std::size_t(number)]; }

  int portalCount() const { return static_cast<int>(frame_->places.size()); }
  /// In map [m].
  const Eigen::Vector2d& placeOf(int portal) const { return frame_->places[std::size_t(portal)]; }
  int sideOf(int portal) const { return frame_->side_of_portal[std::size_t(portal)]; }
  /// Id of the door that a portal belongs to.
  std::uint64_t doorOf(int portal) const;
  /// The portal's number among those of one of its LTRs.
  int portalIn(int ltr, int portal) const;
  Triangle::Local localOf(int ltr, int portal) const;
  /// The portal that is the `index`-th of an LTR, and places of all of them.
  int portalAt(int ltr, int index) const;
  std::vector<Triangle::Local> portalsOf(int ltr) const;
  /// The way that the LTR's matrix keeps, both ends included.
  std::vector<Triangle::Local> wayBetween(int ltr, int from, int to) const;

  const SearchLtr& searchLtr(int number) const { return search_ltrs_[std::size_t(number)]; }
  const SearchSide& searchSide(int number) const {
    return frame_->search_sides[std::size_t(number)];
  }
  /// Places of portals, from origin().
  const Eigen::Vector2f* searchPlaces() const { return frame_->search_places.data(); }
  /// What it costs to enter one of a side's LTRs (`end`) through the `i`-th portal, because a layer
  /// rises or falls from the other LTR to it.
  float crossing(const SearchSide& side, int i, std::size_t end) const {
    return side.crossing == kNone ? 0.0F
                                  : frame_->crossings[2 * std::size_t(side.crossing + i) + end];
  }
  /// In map, near all LTRs [m].
  const Eigen::Vector2d& origin() const { return frame_->low; }

  /// Lower bound of the cost of a metre as the crow flies, over all LTRs: the least of K mu_min
  /// over the share by which lengths have grown since the costs were computed.
  double leastPerMetre() const { return least_; }
  double maxMetricError() const { return max_metric_error_; }

  /// Whether what a place in an LTR holds has come, and it is neither occupied nor too near to what
  /// is.
  bool isPassable(int ltr, const Triangle::Local& local) const {
    const std::shared_ptr<const CellCosts>& costs = this->ltr(ltr).costs;
    return costs && costs->isPassable(costs->grid().index(local));
  }

  /// An LTR that contains a point of map; kNone outside of all.
  int locate(const Eigen::Vector2d& point) const;

  /// K times mu, integrated along a straight line in map that starts in an LTR and may cross
  /// others; infinite where it is blocked or leaves the map. `weighted` false: without K.
  double integrate(int start_ltr, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                   bool weighted = true) const;

  /// The same where the line may start on a side, along which only one of the LTRs may be free:
  /// `start_ltr` is tried first, then the others that contain the start.
  double integrateFromAny(int start_ltr, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                          bool weighted = true) const;

  /// The same with other contents of some LTRs; nothing if their doors, or costs of going from one
  /// to another, would be others too. Costs a copy of the LTRs' pointers.
  std::shared_ptr<const DoorGraph> with(const std::vector<GraphChange>& changes) const;

  std::size_t bytes() const;

 private:
  /// What stays as it is while LTRs come to hold other things: shared by the graphs of that time.
  struct Frame {
    std::vector<GraphSide> sides;
    std::vector<Eigen::Vector2d> places;  ///< of portals
    std::vector<int> side_of_portal;
    std::vector<SearchSide> search_sides;
    std::vector<Eigen::Vector2f> search_places;
    std::vector<float> crossings;  ///< by portal of sides that need them, then end
    // LTRs by square buckets of map, those of a bucket one after another.
    Eigen::Vector2d low = Eigen::Vector2d::Zero();
    double bucket_m = 1.0;
    int bucket_columns = 0, bucket_rows = 0;
    std::vector<int> bucket_starts;
    std::vector<int> bucket_ltrs;

    std::size_t bytes() const;
  };
  void numberPortals(Frame& frame);
  void spanBuckets(Frame& frame) const;
  void fillBuckets(Frame& frame) const;
  void prepareSearch(Frame& frame);
  void addCrossings(Frame& frame, SearchSide& side) const;
  std::int64_t bucketOf(const Eigen::Vector2d& point) const;

  std::vector<GraphLtr> ltrs_;
  std::vector<SearchLtr> search_ltrs_;
  std::shared_ptr<const Frame> frame_ = std::make_shared<const Frame>();
  double least_ = kNoPassing;
  double max_metric_error_ = 0.02;
};

}  // namespace hymm::core
