#pragma once

#include <map>
#include <vector>

#include <Eigen/Core>

#include "door_planner/barrier.h"
#include "hybrid_map/ltr_index.h"

namespace hymm::core {

/// Landmarks as discs in map, found by place.
class LandmarkDiscs {
 public:
  /// `usual_diameter_m`: of landmarks whose diameter is not known, or makes no sense.
  explicit LandmarkDiscs(double usual_diameter_m);

  /// All landmarks there are; those at no finite place are left out. Returns the discs that are
  /// new, that are gone, and, before and after, that have changed.
  std::vector<Barrier> set(const std::vector<SolidLandmark>& landmarks);

  /// Calls `visit(disc)` for the discs near the box from `low` to `high` [m], and for none twice.
  template <class Visitor>
  void visit(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Visitor&& visitor) const {
    index_.visit(low, high, [&](int disc) { visitor(discs_[std::size_t(disc)]); });
  }

 private:
  Barrier discOf(const SolidLandmark& landmark) const;

  double usual_diameter_m_;
  std::map<int, SolidLandmark> landmarks_;  ///< by id
  std::vector<Barrier> discs_;
  LtrIndex index_;  ///< of places in `discs_`
};

}  // namespace hymm::core
