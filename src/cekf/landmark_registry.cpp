#include "cekf/landmark_registry.h"

#include <algorithm>

namespace hymm::core {

RegisteredLandmark& LandmarkRegistry::add(const RegisteredLandmark& landmark) {
  id_of_slot_[landmark.slot] = landmark.id;
  if (landmark.identity >= 0) id_of_identity_[landmark.identity] = landmark.id;
  index_.place(landmark.slot, landmark.position);
  largest_deviation_m_ = std::max(largest_deviation_m_, landmark.deviation_m);
  return landmarks_[landmark.id] = landmark;
}

void LandmarkRegistry::remove(int id) {
  const RegisteredLandmark& landmark = landmarks_.at(id);
  index_.remove(landmark.slot);
  id_of_slot_.erase(landmark.slot);
  if (landmark.identity >= 0) id_of_identity_.erase(landmark.identity);
  landmarks_.erase(id);
}

void LandmarkRegistry::clear() {
  landmarks_.clear();
  id_of_slot_.clear();
  id_of_identity_.clear();
  index_.clear();
  largest_deviation_m_ = 0.0;
}

RegisteredLandmark* LandmarkRegistry::findIdentity(int identity) {
  const auto known = id_of_identity_.find(identity);
  return known == id_of_identity_.end() ? nullptr : &landmarks_.at(known->second);
}

double LandmarkRegistry::move(RegisteredLandmark& landmark, const Eigen::Vector2d& position) {
  const double moved = (position - landmark.position).norm();
  landmark.position = position;
  index_.place(landmark.slot, position);
  return moved;
}

void LandmarkRegistry::setDeviations(const std::vector<std::pair<int, double>>& deviations_by_id) {
  largest_deviation_m_ = 0.0;
  for (const auto& [id, deviation_m] : deviations_by_id) {
    landmarks_.at(id).deviation_m = deviation_m;
    largest_deviation_m_ = std::max(largest_deviation_m_, deviation_m);
  }
}

std::vector<int> LandmarkRegistry::slotsNear(const Eigen::Vector2d& centre, double radius_m) const {
  std::vector<int> slots = index_.near(centre, radius_m);
  const auto too_far = [&](int slot) {
    return (bySlot(slot).position - centre).squaredNorm() > radius_m * radius_m;
  };
  slots.erase(std::remove_if(slots.begin(), slots.end(), too_far), slots.end());
  return slots;
}

std::vector<int> LandmarkRegistry::ids() const {
  std::vector<int> ids;
  ids.reserve(landmarks_.size());
  for (const auto& entry : landmarks_) ids.push_back(entry.first);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace hymm::core
