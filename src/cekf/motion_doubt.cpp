#include "cekf/motion_doubt.h"

#include <algorithm>

namespace hymm::core {
namespace {

constexpr double kLongest_s = 3600.0;

}  // namespace

MotionDoubt MotionDoubt::afterReturn(double T0_s, double now_s) const {
  MotionDoubt next;
  next.back_s = now_s;
  const bool again = T0_s - std::max(back_s, until_s) < kFirst_s;
  if (!again) return next;
  next.lasting_s = lasting_s > 0.0 ? std::min(2.0 * lasting_s, kLongest_s) : kFirst_s;
  next.until_s = now_s + next.lasting_s;
  return next;
}

}  // namespace hymm::core
