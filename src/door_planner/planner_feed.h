#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_map.h"
#include "door_planner/door_planner.h"
#include "hybrid_map/ltr_topology.h"

namespace hymm::core {

/// Decodes one layer of an LTR, `channels` numbers a cell as its cell model keeps them, into what
/// the planner weighs: the occupancy's probability, a measured mean, the share of each category,
/// events an hour. `model` is the cell model and its words ("category grass asphalt"). False if
/// the model is not known or the numbers do not fit it.
bool decodeLayer(const std::string& name, const std::string& model, int channels,
                 const std::vector<float>& cells, LtrContent& content);

/// Gathers topology, landmarks and layers, in whatever order they come, and tells a planner what
/// has changed since it was last told.
class PlannerFeed {
 public:
  /// All LTRs there are.
  void setTopology(const std::vector<LtrTopology>& topology);
  /// Places and diameters of landmarks; those that are not in it are no more.
  void setLandmarks(const std::vector<LandmarkEstimate>& landmarks);
  /// A layer of an LTR; false if it cannot be decoded.
  bool setLayer(int ltr, const std::string& name, const std::string& model, int channels,
                const std::vector<float>& cells);
  void reset();

  /// LTRs whose landmarks are all known, and contents of those that are there. An LTR of which no
  /// layer has come is told as unknown ground. Returns whether there was anything to tell; contents
  /// that the planner refused are counted.
  bool tell(DoorPlanner& planner);

  std::optional<Eigen::Vector2d> findLandmark(int id) const;
  std::size_t refusedContents() const { return refused_; }

  /// Of the LTRs that were told last: those that the planner left out, and how many were not told
  /// because one of their landmarks had not come.
  const UnusableLtrs& unusable() const { return unusable_; }
  std::size_t waiting() const { return waiting_; }

 private:
  std::map<int, LtrTopology> topology_;
  std::unordered_map<int, Eigen::Vector2d> landmarks_;
  std::vector<SolidLandmark> solids_;                                    ///< the same
  std::unordered_map<int, std::shared_ptr<const LtrContent>> contents_;  ///< shared with planners
  std::set<int> told_;     ///< LTRs that the planner knows
  std::set<int> changed_;  ///< contents
  bool geometry_changed_ = false;
  std::size_t refused_ = 0;
  UnusableLtrs unusable_;
  std::size_t waiting_ = 0;
};

}  // namespace hymm::core
