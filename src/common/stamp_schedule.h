#pragma once

#include <optional>

namespace hymm::core {

/// What is to happen once in a period of a recording's own time: at the first stamp, when the
/// period is over, and when stamps ran back.
class StampSchedule {
 public:
  explicit StampSchedule(double period_s) : period_s_(period_s) {}

  /// Whether it is due; if so, the next period begins.
  bool takeIfDue(double time_s) {
    const bool is_due = !last_s_ || time_s >= *last_s_ + period_s_ || time_s < *last_s_;
    if (is_due) last_s_ = time_s;
    return is_due;
  }

 private:
  double period_s_;
  std::optional<double> last_s_;
};

}  // namespace hymm::core
