#include "door_planner/landmark_discs.h"

#include <utility>

#include "hybrid_map/input_check.h"

namespace hymm::core {
namespace {

constexpr double kIndexCell_m = 10.0;
/// Wider than anything that a robot passes: the index would fill with the disc's cells.
constexpr double kWidest_m = 100.0;

}  // namespace

LandmarkDiscs::LandmarkDiscs(double usual_diameter_m)
    : usual_diameter_m_(usual_diameter_m), index_(kIndexCell_m) {}

Barrier LandmarkDiscs::discOf(const SolidLandmark& landmark) const {
  const bool is_told = landmark.diameter_m >= 0.0 && landmark.diameter_m <= kWidest_m;
  const double diameter_m = is_told ? landmark.diameter_m : usual_diameter_m_;
  return {{landmark.id, landmark.id}, landmark.place, landmark.place, 0.5 * diameter_m};
}

std::vector<Barrier> LandmarkDiscs::set(const std::vector<SolidLandmark>& landmarks) {
  std::map<int, SolidLandmark> before = std::exchange(landmarks_, {});
  discs_.clear();
  index_ = LtrIndex(kIndexCell_m);
  std::vector<Barrier> changed;
  for (const SolidLandmark& landmark : landmarks) {
    if (!isPlace(landmark.place)) continue;
    landmarks_[landmark.id] = landmark;
    const Barrier disc = discOf(landmark);
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(disc.radius_m);
    index_.place(static_cast<int>(discs_.size()), disc.from - radius, disc.from + radius);
    discs_.push_back(disc);
    const auto old = before.find(landmark.id);
    if (old != before.end() && old->second == landmark) {
      before.erase(old);
    } else {
      changed.push_back(disc);
    }
  }
  for (const auto& [id, landmark] : before) changed.push_back(discOf(landmark));
  return changed;
}

}  // namespace hymm::core
