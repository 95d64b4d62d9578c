#pragma once

#include <deque>

#include "cekf/landmark_map.h"

namespace hymm::core {

/// The filter's landmark map as messages tell it: whole maps now and then, changes in between. A
/// whole map takes a while to be made: changes that overtook it are made again on it.
class LandmarkMirror {
 public:
  /// Its landmarks may come in any order; of several under one id the first counts.
  void take(const LandmarkMap& map);

  /// Returns false if changes in between are missing: the mirror waits for the next whole map.
  bool take(const LandmarkUpdate& update);

  /// Sorted by id, each once. Cross-covariances are those of the last whole map.
  const LandmarkMap& map() const { return map_; }

 private:
  void apply(const LandmarkUpdate& update);
  void change(const LandmarkEstimate& landmark);
  void remove(int id);

  LandmarkMap map_;
  std::deque<LandmarkUpdate> recent_;  ///< the last changes, each following on the one before
};

}  // namespace hymm::core
