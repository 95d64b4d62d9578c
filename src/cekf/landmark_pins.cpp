#include "cekf/landmark_pins.h"

#include <utility>

namespace hymm::core {

void LandmarkPins::tell(double time_s, const std::vector<int>& ids) {
  const double from_s = time_s + delay_s_;
  while (!later_.empty() && later_.back().from_s >= from_s) later_.pop_back();
  later_.push_back({from_s, {ids.begin(), ids.end()}});
}

const std::unordered_set<int>& LandmarkPins::at(double time_s) {
  while (!later_.empty() && later_.front().from_s <= time_s) {
    now_ = std::move(later_.front().ids);
    later_.pop_front();
  }
  return now_;
}

void LandmarkPins::beginSession() {
  if (later_.empty()) return;
  now_ = std::move(later_.back().ids);
  later_.clear();
}

void LandmarkPins::clear() {
  later_.clear();
  now_.clear();
}

}  // namespace hymm::core
