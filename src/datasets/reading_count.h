#pragma once

#include <cstddef>
#include <string>

namespace hymm::core {

/// Something that was left out on reading, or read with a reservation, and how often.
struct ReadingCount {
  std::string what;  ///< for instance "observations of other robots, skipped"
  std::size_t count = 0;
};

}  // namespace hymm::core
