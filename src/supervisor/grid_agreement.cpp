#include "supervisor/grid_agreement.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

constexpr double kLag_s = 1.0;     // so much later it has come, if the machine keeps up
constexpr double kOldest_s = 3.0;  // beyond that it is of another place
constexpr std::size_t kMostKept = 100;

}  // namespace

void GridAgreement::take(double time_s, double correlation) {
  if (!told_.empty() && time_s < told_.back().time_s) told_.clear();
  told_.push_back({time_s, correlation});
  if (told_.size() > kMostKept) told_.pop_front();
}

double GridAgreement::disagreementAt(double time_s) const {
  const auto newest = std::find_if(told_.rbegin(), told_.rend(), [&](const Told& told) {
    return told.time_s <= time_s - kLag_s;
  });
  const bool is_known = newest != told_.rend() && newest->time_s >= time_s - kOldest_s &&
                        std::isfinite(newest->correlation);
  return is_known ? 1.0 - std::clamp(newest->correlation, 0.0, 1.0) : 0.0;
}

}  // namespace hymm::core
