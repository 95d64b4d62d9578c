#include "evaluation/fix_gate.h"

namespace hymm::core {

bool FixGate::keep(double time_s, const Eigen::Vector2d& position_m) {
  if (last_) {
    const double distance_m = (position_m - last_->position_m).norm();
    // Written so that a NaN is left out.
    if (!(distance_m <= kFastest_mps * (time_s - last_->time_s))) return false;
  }
  last_ = Kept{time_s, position_m};
  return true;
}

}  // namespace hymm::core
