#pragma once

#include <limits>

namespace hymm::core {

/// Until when the motion input is believed less than its noise claims. A filter that was lost once
/// was misled by what it saw, or the vehicle was carried. One that is lost again soon after it came
/// back was told of the motion wrongly: for a while then, and twice as long each time that it is
/// lost again within or soon after that.
struct MotionDoubt {
  static constexpr double kFirst_s = 60.0;  ///< that it lasts for, and what counts as soon
  static constexpr double kFactor = 3.0;    ///< that the noise's deviations are taken meanwhile

  double back_s = -std::numeric_limits<double>::infinity();   ///< stamp at the last return
  double until_s = -std::numeric_limits<double>::infinity();  ///< the doubt's end
  double lasting_s = 0.0;                                     ///< that it lasts for; 0: no doubt

  /// After a return at `now_s` of a filter that was in good order until `T0_s`.
  MotionDoubt afterReturn(double T0_s, double now_s) const;
};

}  // namespace hymm::core
