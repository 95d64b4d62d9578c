#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/diameter_states.h"
#include "cekf/landmark_index.h"
#include "cekf/lasting_errors.h"
#include "perception/observation.h"

namespace hymm::core {

/// What is known of a landmark beside its place in the filter's state.
struct RegisteredLandmark {
  int id = -1;
  int slot = -1;      ///< in the filter
  int identity = -1;  ///< as the sensor reads it, where it does
  LandmarkType type = LandmarkType::kUnknown;
  double diameter_m = 0.0;          ///< NaN where unknown
  double diameter_variance = 0.0;   ///< m^2, NaN where unknown
  DiameterState diameter_state;     ///< of which these two are copies, if it exists
  LastingErrorState lasting_error;  ///< of its sightings
  int observations = 0;
  double first_seen_s = 0.0;
  double last_seen_s = 0.0;
  double farthest_seen_m = 0.0;  ///< range of its farthest observation
  double existence_log_odds = 0.0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< last known; the filter's is the truth
  double deviation_m = 0.0;  ///< bound of its deviation in the map; may lag behind the filter's
  /// Where Jacobians are taken, if not at the latest estimate; see relinearise().
  Eigen::Vector2d linearised_at = Eigen::Vector2d::Zero();

  template <class Archive>
  void describeState(Archive& archive) {
    archive(id, slot, identity, type, diameter_m, diameter_variance, diameter_state, observations,
            first_seen_s, last_seen_s, farthest_seen_m, existence_log_odds, position, deviation_m,
            linearised_at, lasting_error);
  }
};

/// All landmarks of the map, found by id, slot, identity or place.
class LandmarkRegistry {
 public:
  /// Takes in a landmark; id and slot must be new.
  RegisteredLandmark& add(const RegisteredLandmark& landmark);
  void remove(int id);
  void clear();

  RegisteredLandmark& bySlot(int slot) { return by_slot_.at(static_cast<std::size_t>(slot)); }
  const RegisteredLandmark& bySlot(int slot) const {
    return by_slot_.at(static_cast<std::size_t>(slot));
  }
  const RegisteredLandmark& byId(int id) const { return bySlot(slot_of_id_.at(id)); }
  RegisteredLandmark& byId(int id) { return bySlot(slot_of_id_.at(id)); }
  bool contains(int id) const { return slot_of_id_.count(id) > 0; }
  /// Null if there is none.
  RegisteredLandmark* findIdentity(int identity);

  /// Notes where a landmark is now; returns how far it moved [m].
  double move(RegisteredLandmark& landmark, const Eigen::Vector2d& position);

  /// Largest deviation_m that any landmark has had since the last noteLargestDeviation().
  double largestDeviation() const { return largest_deviation_m_; }
  void noteLargestDeviation();

  /// Slots of landmarks within `radius_m` of `centre`, ascending.
  std::vector<int> slotsNear(const Eigen::Vector2d& centre, double radius_m) const;

  /// By slot; those with id -1 are none.
  const std::vector<RegisteredLandmark>& slots() const { return by_slot_; }
  std::vector<RegisteredLandmark>& slots() { return by_slot_; }
  /// Copies of all landmarks, by ascending slot.
  std::vector<RegisteredLandmark> all() const;
  std::size_t size() const { return slot_of_id_.size(); }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(by_slot_, largest_deviation_m_);
    if constexpr (Archive::kReads) {
      if (!findAgain()) archive.fail("two landmarks have one id, slot or identity");
    }
  }

 private:
  /// Finds everything by what by_slot_ says; false if that is not one map.
  bool findAgain();

  std::vector<RegisteredLandmark> by_slot_;
  std::unordered_map<int, int> slot_of_id_;
  std::unordered_map<int, int> slot_of_identity_;
  LandmarkIndex index_;
  double largest_deviation_m_ = 0.0;
};

}  // namespace hymm::core
