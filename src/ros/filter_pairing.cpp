#include "ros/filter_pairing.h"

#include <algorithm>

namespace hymm {
namespace {

constexpr std::size_t kMostWaiting = 1000;

}  // namespace

std::optional<FilterAnswer> FilterPairing::next() {
  for (auto pose = poses_.begin(); pose != poses_.end(); ++pose) {
    const auto health = std::find_if(healths_.begin(), healths_.end(), [&](const auto& waiting) {
      return waiting.header.stamp == pose->header.stamp;
    });
    if (health == healths_.end()) continue;
    const FilterAnswer answer{*pose, *health};
    unpaired_ += static_cast<std::size_t>((pose - poses_.begin()) + (health - healths_.begin()));
    poses_.erase(poses_.begin(), pose + 1);
    healths_.erase(healths_.begin(), health + 1);
    return answer;
  }
  bound(poses_);
  bound(healths_);
  return std::nullopt;
}

template <class Message>
void FilterPairing::bound(std::deque<Message>& waiting) {
  for (; waiting.size() > kMostWaiting; ++unpaired_) waiting.pop_front();
}

}  // namespace hymm
