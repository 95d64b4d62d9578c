#pragma once

#include <optional>
#include <unordered_map>
#include <utility>

#include <Eigen/Core>

#include "cekf/landmark_map.h"

namespace hymm::core {

/// Where landmarks are, by id, and what became of those that were merged.
class LandmarkPlaces {
 public:
  void apply(const LandmarkMap& map);
  void apply(const LandmarkUpdate& update);

  /// The landmark that this one is now, itself or what it was merged into; -1 if it is no more.
  int presentId(int id) const;

  /// Of a landmark, or of the one that it was merged into [m]; nothing if it is no more.
  std::optional<Eigen::Vector2d> find(int id) const;

  /// Of a landmark itself [m].
  std::optional<Eigen::Vector2d> findUnmerged(int id) const;

  /// The landmark nearest to a place within `range_m`, and the nearest besides that is at least
  /// `separation_m` away from it; -1 where there is none.
  std::pair<int, int> nearestTwo(const Eigen::Vector2d& place, double range_m,
                                 double separation_m) const;

  template <class Archive>
  void describeState(Archive& archive) {
    archive(places_, merged_into_);
  }

 private:
  int nearest(const Eigen::Vector2d& place, double range_m, int apart_from,
              double separation_m) const;

  std::unordered_map<int, Eigen::Vector2d> places_;
  std::unordered_map<int, int> merged_into_;
};

}  // namespace hymm::core
