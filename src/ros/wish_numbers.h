#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include <ros/time.h>

namespace hymm {

/// Numbers wishes of an operator by the clock, so that those of a node that was started anew are
/// not taken for ones that were heard.
class WishNumbers {
 public:
  /// Of the last wish; 0: there was none.
  std::uint64_t last() const { return last_; }
  /// Later than all before even if the clock was set back.
  void add(const ros::WallTime& now) { last_ = std::max(last_ + 1, number(now)); }

  static std::uint64_t number(const ros::WallTime& time) { return time.toNSec() / 1000U; }

 private:
  std::uint64_t last_ = 0;
};

/// Hears each wish once, from numbers that are told again and again.
class WishListener {
 public:
  /// Wishes before `start` are for others.
  explicit WishListener(const ros::WallTime& start) : start_(WishNumbers::number(start)) {}

  void take(std::uint64_t number) {
    const bool is_new = last_ ? number != *last_ : number > start_;
    is_waiting_ = is_waiting_ || (number != 0 && is_new);
    if (number != 0 || !last_) last_ = number;
  }
  /// Whether there was a wish since the last call.
  bool takeNew() { return std::exchange(is_waiting_, false); }

 private:
  std::uint64_t start_;
  std::optional<std::uint64_t> last_;
  bool is_waiting_ = false;
};

}  // namespace hymm
