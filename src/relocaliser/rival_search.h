#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "relocaliser/density_map.h"
#include "relocaliser/local_map.h"

namespace hymm::core {

/// A place that is believed, and what makes another one its rival.
struct RivalQuestion {
  std::vector<LocalLandmark> landmarks;
  std::vector<ObservedPoint> points;  ///< of the last scans, in the vehicle's present axes
  double view_m2 = 0.0;
  DensityConfig density;
  std::optional<PosePrior> prior;  ///< local frame; nothing: a rival may be anywhere
  double prior_deviations = 3.0;   ///< beyond these there is none
  Pose2 believed;                  ///< local frame
  double distance_m = 1.5;         ///< farther from it, or ...
  double angle_rad = 0.2;          ///< ... turned by more, is another place
  double log_likelihood = 0.0;     ///< that a rival exceeds, as logLikelihoodAt() tells it
  std::size_t most_bounds = 0;     ///< on groups of points; then the search gives up
};

struct RivalAnswer {
  enum class Kind {
    kNoRival,   ///< no other place exceeds the likelihood: proven
    kRival,     ///< one does, or comes so near to it that boxes of a few millimetres cannot tell
    kUndecided  ///< the bounds that were allowed are used up
  };
  Kind kind = Kind::kUndecided;
  std::size_t bounds = 0;  ///< on groups of points, that it took
};

/// Whether another place explains the points as well, by branch and bound over all poses: a box of
/// poses in which even the best value that each point can take on its own adds up to too little
/// holds no rival, the others are split. However narrow a peak is, it cannot be missed. Goes on
/// whenever work() is called; the answer does not depend on how often that is.
class RivalSearch {
 public:
  explicit RivalSearch(RivalQuestion question);
  ~RivalSearch();
  RivalSearch(RivalSearch&& other) noexcept;
  RivalSearch& operator=(RivalSearch&& other) noexcept;

  /// Does so many steps, of some nanoseconds each, and what it is at; fewer if it is done. Nothing
  /// as long as the answer is not known.
  std::optional<RivalAnswer> work(std::size_t steps);

 private:
  class Boxes;

  std::optional<RivalAnswer> answer_;
  std::unique_ptr<Boxes> boxes_;  ///< null once there is an answer
};

/// The same at once.
RivalAnswer findRival(RivalQuestion question);

}  // namespace hymm::core
