#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json.h"
#include "evaluation/gps_error.h"
#include "evaluation/landmark_error.h"
#include "evaluation/pose_error.h"
#include "evaluation/run_results.h"

namespace hymm::core {

/// What a run's results are compared with. Empty where there is none of a kind.
struct Reference {
  std::vector<StampedPose> poses;          ///< true poses of base_link
  std::vector<Eigen::Vector2d> landmarks;  ///< true places
  bool in_map_frame = true;  ///< else in a frame of their own, and moved to the map's first pose
  std::vector<StampedPosition> fixes;          ///< GPS, in a frame of its own
  std::optional<Eigen::Vector2d> gps_antenna;  ///< place in base_link
  bool landmarks_in_gps_frame = false;         ///< surveyed: neither truth's frame nor the map's
};

struct EvaluationOptions {
  TimeWindow window;
  double landmark_gate_m = 1.0;
  double missed_range_m = 20.0;
};

/// Errors of a run as JSON, and sentences about what could not be computed and why. Members
/// `trajectory`, `landmarks`, `gps`, `nis` are null where they could not.
struct EvaluationReport {
  JsonObject json;
  std::vector<std::string> remarks;
};

EvaluationReport evaluate(const RunResults& results, const Reference& reference,
                          const EvaluationOptions& options);

}  // namespace hymm::core
