#include "cekf/landmark_registry.h"

#include <algorithm>

namespace hymm::core {

RegisteredLandmark& LandmarkRegistry::add(const RegisteredLandmark& landmark) {
  const auto slot = static_cast<std::size_t>(landmark.slot);
  if (slot >= by_slot_.size()) by_slot_.resize(slot + 1);
  slot_of_id_[landmark.id] = landmark.slot;
  if (landmark.identity >= 0) slot_of_identity_[landmark.identity] = landmark.slot;
  index_.place(landmark.slot, landmark.position);
  largest_deviation_m_ = std::max(largest_deviation_m_, landmark.deviation_m);
  return by_slot_[slot] = landmark;
}

void LandmarkRegistry::remove(int id) {
  RegisteredLandmark& landmark = byId(id);
  index_.remove(landmark.slot);
  slot_of_id_.erase(id);
  if (landmark.identity >= 0) slot_of_identity_.erase(landmark.identity);
  landmark = RegisteredLandmark{};
}

void LandmarkRegistry::clear() {
  by_slot_.clear();
  slot_of_id_.clear();
  slot_of_identity_.clear();
  index_.clear();
  largest_deviation_m_ = 0.0;
}

RegisteredLandmark* LandmarkRegistry::findIdentity(int identity) {
  const auto known = slot_of_identity_.find(identity);
  return known == slot_of_identity_.end() ? nullptr : &bySlot(known->second);
}

double LandmarkRegistry::move(RegisteredLandmark& landmark, const Eigen::Vector2d& position) {
  const double moved = (position - landmark.position).norm();
  landmark.position = position;
  index_.place(landmark.slot, position);
  return moved;
}

void LandmarkRegistry::noteLargestDeviation() {
  largest_deviation_m_ = 0.0;
  for (const RegisteredLandmark& landmark : by_slot_) {
    if (landmark.id >= 0)
      largest_deviation_m_ = std::max(largest_deviation_m_, landmark.deviation_m);
  }
}

bool LandmarkRegistry::findAgain() {
  slot_of_id_.clear();
  slot_of_identity_.clear();
  index_.clear();
  for (std::size_t slot = 0; slot < by_slot_.size(); ++slot) {
    const RegisteredLandmark& landmark = by_slot_[slot];
    if (landmark.id < 0) continue;
    const bool is_new = landmark.slot == static_cast<int>(slot) && landmark.position.allFinite() &&
                        slot_of_id_.emplace(landmark.id, landmark.slot).second;
    if (!is_new) return false;
    const bool has_identity = landmark.identity >= 0;
    if (has_identity && !slot_of_identity_.emplace(landmark.identity, landmark.slot).second) {
      return false;
    }
    index_.place(landmark.slot, landmark.position);
  }
  return true;
}

std::vector<int> LandmarkRegistry::slotsNear(const Eigen::Vector2d& centre, double radius_m) const {
  std::vector<int> slots = index_.near(centre, radius_m);
  const auto too_far = [&](int slot) {
    return (bySlot(slot).position - centre).squaredNorm() > radius_m * radius_m;
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), too_far), slots.end());
  return slots;
}

std::vector<RegisteredLandmark> LandmarkRegistry::all() const {
  std::vector<RegisteredLandmark> landmarks;
  landmarks.reserve(size());
  std::copy_if(by_slot_.begin(), by_slot_.end(), std::back_inserter(landmarks),
               [](const RegisteredLandmark& landmark) { return landmark.id >= 0; });
  return landmarks;
}

}  // namespace hymm::core
