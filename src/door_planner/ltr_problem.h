#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "door_planner/ltr_view.h"

namespace hymm::core {

/// Why the planner leaves an LTR out: its numbers make no sense, or would take more memory or time
/// than there is.
enum class LtrProblem {
  kId,            ///< negative, or far beyond any number of LTRs
  kPlace,         ///< a corner that is not finite, or not on earth
  kTooWide,       ///< kilometres
  kFlat,          ///< corners in a line, or clockwise
  kNoCells,       ///< along one of its sides, or a negative number
  kTooManyCells,  ///< for the memory
  kNarrowCells,   ///< many times as long as wide: searches in them would need thousands of steps
};

/// Nothing if the planner can use it.
std::optional<LtrProblem> problemOf(const LtrView& view);

/// What to say of an LTR with it: "has …".
std::string wordsFor(LtrProblem problem);

/// By id.
using UnusableLtrs = std::map<int, LtrProblem>;

/// How many there are of each problem, by its words.
std::map<std::string, std::size_t> countsOf(const UnusableLtrs& ltrs);

}  // namespace hymm::core
