#include "cekf/active_area.h"

#include <algorithm>

namespace hymm::core {

bool ActiveArea::follow(const Eigen::Vector2d& position) {
  const double away = (position - centre_).cwiseAbs().maxCoeff();
  if (away <= 0.5 * config_.cell_m + config_.hysteresis_m) return false;
  centre_ = (position / config_.cell_m).array().round() * config_.cell_m;
  due_ = true;
  ++counts_.switches;
  return true;
}

/// Landmarks that came into the map since the last update are active, and no origins.
int ActiveArea::sizeOf(const CompressedEkf& filter) {
  return std::max(filter.originStates(), 2 * static_cast<int>(filter.activeCount()));
}

void ActiveArea::updateIfDue(CompressedEkf& filter) {
  const int size = sizeOf(filter);
  due_ = due_ || size > config_.max_origin_states;
  if (!due_) return;
  if (filter.isGlobalUpdatePending()) {
    if (!deferred_) ++counts_.deferred;
    deferred_ = true;
    if (size <= 2 * config_.max_origin_states) return;
    ++counts_.waits;
    filter.finishGlobalUpdate();
  }
  filter.globalUpdate();
  ++counts_.global_updates;
  due_ = deferred_ = false;
}

void ActiveArea::reset() {
  centre_.setZero();
  due_ = deferred_ = false;
}

}  // namespace hymm::core
