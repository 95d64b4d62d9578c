#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "door_planner/door_map.h"
#include "door_planner/plan.h"

namespace hymm::core {

/// Doors and costs by other weights than those that are configured, for requests that bring their
/// own. They are made when they are first asked for, and kept for the next request with the same
/// weights. One thread tells of the map, any may ask.
class WeightedMaps {
 public:
  explicit WeightedMaps(const DoorPlannerConfig& config) : config_(config) {}

  void setLtrs(const std::vector<LtrView>& ltrs);
  void setLandmarks(const std::vector<SolidLandmark>& landmarks);
  void setContent(int ltr, std::shared_ptr<const LtrContent> content);

  /// Up to date, with `weights` (PathCostConfig::with) in place of those that are configured; null,
  /// with a status and a sentence in `refused`, if they cannot be used or it is interrupted. What
  /// was computed before an interruption is kept. Waits for a request that prepares the same, or
  /// where as many sets as are kept are being prepared, but not when it is interrupted.
  std::shared_ptr<const DoorGraph> graphFor(const std::string& weights,
                                            const Eigen::Vector2d& place,
                                            const std::function<PlanStatus()>& interrupted,
                                            Plan& refused);

  /// A sentence, after a blank, about each layer in `weights` that no LTR holds: perhaps it is
  /// misspelt, perhaps nothing of it was measured yet. Empty if there is none.
  std::string remarkOn(const std::string& weights) const;

 private:
  struct Variant {
    std::string weights;
    bool is_taken = false;  ///< by a request, to which what follows belongs then
    DoorMap map;
    std::uint64_t version = 0;  ///< of the map that it was told of
    std::map<int, std::shared_ptr<const LtrContent>> contents;
    std::shared_ptr<const DoorGraph> graph;

    Variant(const std::string& of, const DoorPlannerConfig& config) : weights(of), map(config) {}
  };
  using Interrupted = std::function<PlanStatus()>;

  std::optional<DoorPlannerConfig> configFor(const std::string& weights, Plan& refused) const;
  std::shared_ptr<Variant> findFree(const std::string& weights, const DoorPlannerConfig& config);
  std::shared_ptr<Variant> take(const std::string& weights, const Interrupted& interrupted,
                                Plan& refused);
  void giveBack(Variant& variant);
  PlanStatus tell(Variant& variant, const Interrupted& interrupted);
  PlanStatus prepare(Variant& variant, const Eigen::Vector2d& place,
                     const Interrupted& interrupted);

  DoorPlannerConfig config_;
  mutable std::mutex map_mutex_;  ///< over what follows
  std::vector<LtrView> ltrs_;
  std::vector<SolidLandmark> landmarks_;
  std::map<int, std::shared_ptr<const LtrContent>> contents_;
  std::uint64_t version_ = 1;
  std::mutex variants_mutex_;                     ///< over what follows; held for moments only
  std::condition_variable given_back_;            ///< a variant
  std::list<std::shared_ptr<Variant>> variants_;  ///< the last used first
};

}  // namespace hymm::core
