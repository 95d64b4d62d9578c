#pragma once

#include <cstdint>
#include <optional>

namespace hymm::core {

/// What a filter counts, as its messages tell it: each only grows while the filter lives. What a
/// topic does not tell stays 0.
struct FilterCounters {
  std::uint64_t version = 0;  ///< of the landmarks
  std::uint64_t resets = 0;   ///< maps begun anew, or loaded
  std::uint64_t scans = 0;    ///< taken
};

enum class FilterCourse {
  kGoesOn,
  kNewMap,     ///< the same filter began its map anew: landmark ids start again
  kNewFilter,  ///< it was started anew, and begins with its map
};

/// Tells from one topic, or from what was brought together of several, whether it is still the
/// same filter that speaks: one that was started anew counts from 0 again. Messages must be in the
/// order in which they were sent, as one topic brings them.
class FilterLife {
 public:
  /// Of the next message, against the last one taken. The first message goes on.
  FilterCourse courseOf(const FilterCounters& next) const {
    if (!last_) return FilterCourse::kGoesOn;
    const bool ran_back =
        next.version < last_->version || next.resets < last_->resets || next.scans < last_->scans;
    if (ran_back) return FilterCourse::kNewFilter;
    return next.resets > last_->resets ? FilterCourse::kNewMap : FilterCourse::kGoesOn;
  }

  FilterCourse take(const FilterCounters& next) {
    const FilterCourse course = courseOf(next);
    last_ = next;
    return course;
  }

 private:
  std::optional<FilterCounters> last_;
};

}  // namespace hymm::core
