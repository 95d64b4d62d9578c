#pragma once

#include <optional>
#include <string>
#include <vector>

namespace hymm {

/// What arguments of `rosbag play` say of the part of the bag that is played.
struct PlayerArguments {
  double start_s = 0.0;              ///< into the bag
  std::optional<double> duration_s;  ///< of the bag; to its end if not told
  bool loops = false;
  std::vector<std::string> topics;  ///< all if empty
};

/// Nothing if an argument is none that is known.
std::optional<PlayerArguments> parsePlayerArguments(const std::string& arguments);

/// Stamps of the bag between which messages are played.
struct PlayedSpan {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// Throws core::InputError if the bag cannot be opened, is empty, or has no message in that part.
PlayedSpan playedSpan(const std::string& bag, const PlayerArguments& arguments);

}  // namespace hymm
