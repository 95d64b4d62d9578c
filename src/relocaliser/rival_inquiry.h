#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "relocaliser/relocaliser.h"
#include "relocaliser/rival_search.h"

namespace hymm::core {

/// Asks local maps, one after the other, whether another place may explain what a relocaliser saw
/// last nearly as well as the one that it believes.
class RivalInquiry {
 public:
  /// `asker` stays as it is, and `maps` live, as long as this does. Place in the map frame.
  RivalInquiry(const Relocaliser& asker, const Pose2& T_map_believed,
               std::vector<const LocalMap*> maps)
      : asker_(asker), T_map_believed_(T_map_believed), maps_(std::move(maps)) {}

  /// Whether there is one, as soon as that is known; not proven not to be one counts as one. Does
  /// about so many steps of a RivalSearch.
  std::optional<bool> work(std::size_t steps);

 private:
  const Relocaliser& asker_;
  Pose2 T_map_believed_;
  std::vector<const LocalMap*> maps_;
  std::size_t next_ = 0;
  std::optional<RivalSearch> search_;  ///< in the map before the next
};

}  // namespace hymm::core
