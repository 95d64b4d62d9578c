#include "hybrid_map/input_check.h"

#include <limits>

namespace hymm::core {

std::optional<std::string> landmarkProblem(const std::vector<LandmarkEstimate>& landmarks) {
  int last_id = std::numeric_limits<int>::min();
  for (const LandmarkEstimate& landmark : landmarks) {
    const std::string name = "landmark " + std::to_string(landmark.id);
    if (!isPlace(landmark.position)) {
      return "the position of " + name + " is not finite, or beyond 10 000 km";
    }
    if (!landmark.covariance.allFinite()) return "the covariance of " + name + " is not finite";
    if (landmark.id < 0) return name + " has a negative id";
    if (landmark.id <= last_id) return name + " does not follow in ascending order of ids";
    last_id = landmark.id;
  }
  return std::nullopt;
}

}  // namespace hymm::core
