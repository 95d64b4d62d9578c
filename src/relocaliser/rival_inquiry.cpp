#include "relocaliser/rival_inquiry.h"

namespace hymm::core {

/// No piece is of two maps.
std::optional<bool> RivalInquiry::work(std::size_t steps) {
  if (!search_) {
    if (next_ == maps_.size()) return false;
    search_.emplace(asker_.rivalQuestion(*maps_[next_++], T_map_believed_));
  }
  const std::optional<RivalAnswer> answer = search_->work(steps);
  if (!answer) return std::nullopt;
  search_.reset();
  if (answer->kind != RivalAnswer::Kind::kNoRival) return true;
  return next_ == maps_.size() ? std::optional(false) : std::nullopt;
}

}  // namespace hymm::core
