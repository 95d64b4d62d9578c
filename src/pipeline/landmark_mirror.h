#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "cekf/landmark_map.h"
#include "pipeline/filter_life.h"

namespace hymm::core {

/// The filter's landmark map as messages tell it: whole maps now and then, changes in between. A
/// whole map takes a while to be made: changes that overtook it are made again on it. Maps come on
/// one topic and changes on another, each in order. Whichever is the first to tell that the filter
/// was started anew ends the landmarks held; what still comes of them on the other is not used.
class LandmarkMirror {
 public:
  /// Its landmarks may come in any order; of several under one id the first counts.
  void take(const LandmarkMap& map);

  /// Returns false if changes in between are missing: the mirror waits for the next whole map.
  bool take(const LandmarkUpdate& update);

  /// That the filter speaks of this version elsewhere, for instance in its poses.
  void hear(std::uint64_t version) { listen(elsewhere_, version); }

  /// Sorted by id, each once. Cross-covariances are those of the last whole map.
  const LandmarkMap& map() const { return map_; }

  /// How often the filter was started anew, with other landmarks under the same ids.
  std::size_t restarts() const { return restarts_; }

 private:
  struct Source {
    FilterLife life;
    std::size_t restarts = 0;  ///< that it is known to have told; fewer: the old filter may speak
  };

  void listen(Source& source, std::uint64_t version);
  bool isTold(std::uint64_t version) const;
  void apply(const LandmarkUpdate& update);
  void change(const LandmarkEstimate& landmark);
  void remove(int id);

  Source maps_, updates_, elsewhere_;
  std::size_t restarts_ = 0;
  LandmarkMap map_;
  std::deque<LandmarkUpdate> recent_;  ///< the last changes, each following on the one before
};

}  // namespace hymm::core
