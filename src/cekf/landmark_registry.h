#pragma once

#include <cstdint>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "cekf/landmark_index.h"
#include "perception/observation.h"

namespace hymm::core {

/// What is known of a landmark beside its place in the filter's state.
struct RegisteredLandmark {
  int id = -1;
  int slot = -1;      ///< in the filter
  int identity = -1;  ///< as the sensor reads it, where it does
  LandmarkType type = LandmarkType::kUnknown;
  double diameter_m = 0.0;         ///< NaN where unknown
  double diameter_variance = 0.0;  ///< m^2, NaN where unknown
  int observations = 0;
  double last_seen_s = 0.0;
  double farthest_seen_m = 0.0;  ///< range of its farthest observation
  double existence_log_odds = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< last known; the filter's is the truth
  double deviation_m = 0.0;  ///< bound of its deviation in the map; may lag behind the filter's
  std::uint64_t changed_version = 0;
  std::set<int> distinct_from;  ///< ids of close landmarks seen in the same scan as this one
};

/// All landmarks of the map, found by id, slot, identity or place. Iteration is by ascending id.
class LandmarkRegistry {
 public:
  /// Takes in a landmark; id and slot must be new.
  RegisteredLandmark& add(const RegisteredLandmark& landmark);
  void remove(int id);
  void clear();

  RegisteredLandmark& bySlot(int slot) { return landmarks_.at(id_of_slot_.at(slot)); }
  const RegisteredLandmark& bySlot(int slot) const { return landmarks_.at(id_of_slot_.at(slot)); }
  /// Null if there is none.
  RegisteredLandmark* findIdentity(int identity);

  /// Notes where a landmark is now; returns how far it moved [m].
  double move(RegisteredLandmark& landmark, const Eigen::Vector2d& position);

  /// Notes the deviation of each landmark; those of landmarks never grow.
  void setDeviations(const std::vector<std::pair<int, double>>& deviations_by_id);
  /// Largest deviation_m of all landmarks.
  double largestDeviation() const { return largest_deviation_m_; }

  /// Slots of landmarks within `radius_m` of `centre`, ascending.
  std::vector<int> slotsNear(const Eigen::Vector2d& centre, double radius_m) const;

  std::vector<int> ids() const;
  const RegisteredLandmark& byId(int id) const { return landmarks_.at(id); }
  RegisteredLandmark& byId(int id) { return landmarks_.at(id); }
  std::size_t size() const { return landmarks_.size(); }

 private:
  std::unordered_map<int, RegisteredLandmark> landmarks_;  ///< by id
  std::unordered_map<int, int> id_of_slot_;
  std::unordered_map<int, int> id_of_identity_;
  LandmarkIndex index_;
  double largest_deviation_m_ = 0.0;
};

}  // namespace hymm::core
