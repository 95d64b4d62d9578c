#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "door_planner/cheapest_first.h"
#include "door_planner/districts.h"
#include "door_planner/door_graph.h"
#include "door_planner/place_link.h"

namespace hymm::core {

/// A* over portals. Portals of a side are taken up together: the costs of the ways from them lie
/// side by side. What is taken up too early is taken up again when it turns out to be cheaper, so
/// that no order of them matters for the outcome. One object serves one search at a time; its
/// memory is used again.
class PortalSearch {
 public:
  /// Where a search may go. All pointers outlive it.
  struct Scope {
    const DoorGraph* graph = nullptr;
    /// Crossed by their matrices, where there are any; null: all is crossed LTR by LTR.
    const Districts* districts = nullptr;
    std::array<int, 2> taken_apart{kNone, kNone};  ///< districts crossed LTR by LTR all the same
    int only = kNone;  ///< a district that is crossed LTR by LTR and not left; kNone: any
    Admits admits;     ///< whether a place may be crossed; ways are taken as they are or not at all
    std::function<bool()> stop;  ///< asked now and then; true ends the search
  };
  /// Portals of a side from which one end of the search is reached, through the side's LTR `end`.
  struct Target {
    int side = kNone;
    std::size_t end = 0;
    std::vector<float> costs;  ///< from each of its portals; infinite where there is no way
  };
  /// A portal on the way, and the LTR or district that the way to it runs through.
  struct Step {
    int portal = kNone;
    int ltr = kNone;  ///< of the portal's side, the one where the way comes from
  };

  /// Towards a place in map, or (nothing given) everywhere.
  void begin(const Scope& scope, const Eigen::Vector2d* from, const Eigen::Vector2d* goal);
  void setTargets(std::vector<Target> targets) { targets_ = std::move(targets); }
  /// Only ways that are cheaper count.
  void limit(float cost) { limit_ = cost; }
  /// A portal that is reached at a cost, through an LTR.
  void offer(int portal, int ltr, float cost);
  /// All that is reached from a portal through an LTR, whose side it lies on.
  void offerFrom(int portal, int ltr) { spread(portal, ltr, 0.0F); }
  /// False if it was stopped.
  bool run();

  /// Of the cheapest way to a target, or the limit, if there is none.
  float cost() const { return limit_; }
  /// The last portal of the cheapest way; kNone if no way was found.
  int last() const { return last_; }
  /// Of the cheapest way to a portal.
  float costTo(int portal) const;
  /// The steps of the cheapest way to the target, from the first portal that was offered, or from
  /// the one after `from`, which offerFrom() began at.
  std::vector<Step> way(int from = kNone) const;

  std::size_t expanded() const { return expanded_; }
  /// Whether the search crosses a district by its matrix.
  bool crossesAtOnce(int district) const {
    return scope_.districts != nullptr && scope_.only == kNone &&
           district != scope_.taken_apart[0] && district != scope_.taken_apart[1] &&
           scope_.districts->matrix(district) != nullptr;
  }

 private:
  struct Label {
    float cost;
    float bound;     ///< h
    float expanded;  ///< cost at which it was last taken up
    /// Twice the portal, or kStart, from which the way comes, plus the end, of the side's LTRs,
    /// that it came through.
    std::int32_t parent;
    std::size_t end() const { return std::size_t(parent & 1); }
    int from() const { return parent >> 1; }
    bool isPending() const { return cost < expanded; }
    float total() const { return cost + bound; }
  };
  /// Labels of sides that another search left behind do not count.
  struct SideState {
    float queued;  ///< total with which it waits
    std::uint32_t search = 0;
  };
  using Entry = CheapestFirst::Entry;  ///< a side, by the least total of its portals
  /// Costs from a portal to those of a side, reached through its LTR `end`.
  struct Row {
    int from;
    float reached;
    const float* costs;
    float factor;
  };
  static constexpr std::int32_t kStart = -1;

  void open(int side);
  void enqueue(int side, float total);
  bool next(Entry& entry);
  void takeUp(const Entry& entry);
  void expand(int side, int portal);
  void spread(int portal, int ltr, float reached);
  float* reachedThrough(int district);
  void spreadAcross(int portal, int side, std::size_t end, int district, float cost);
  void relax(int side, std::size_t end, const Row& row);
  void reach(const Target& target, int portal);

  Scope scope_;
  const DoorGraph* graph_ = nullptr;
  std::vector<Target> targets_;
  bool has_goal_ = false;
  Eigen::Vector2f goal_ = Eigen::Vector2f::Zero();
  float least_ = 0.0F;
  float limit_ = 0.0F;                           ///< of the cheapest way to a target so far
  int last_ = kNone;                             ///< its last portal
  std::vector<Label> labels_;                    ///< by portal
  std::vector<SideState> states_;                ///< by side
  std::vector<float> reached_;                   ///< by portal on the borders of districts
  std::vector<std::uint32_t> reached_searches_;  ///< by district, the search that it was reached in
  CheapestFirst waiting_;                        ///< sides
  float together_ = 0.0F;
  std::uint32_t search_ = 0;
  std::size_t expanded_ = 0;
};

}  // namespace hymm::core
