#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/landmark_map.h"
#include "cekf/resumption.h"
#include "cekf/vehicle_among_landmarks.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// What the filter knows, of one moment.
struct FilterKnowledge {
  VehicleAmongLandmarks estimate;
  Calibration calibration;  ///< of the motion input
};

/// What a relocalisation asks of the filter: offline of the engine itself, live by services.
class FilterLink {
 public:
  virtual ~FilterLink() = default;

  /// All landmarks, without cross-covariances.
  virtual std::vector<LandmarkEstimate> landmarks() = 0;
  /// Takes the filter back to a scan, where it waits. Why it cannot, as a sentence; else empty.
  virtual std::string suspend(double time_T0_s) = 0;
  /// Nothing, and a sentence in `problem`, if the filter does not answer or lacks a landmark.
  virtual std::optional<FilterKnowledge> ask(const std::vector<int>& ids, std::string& problem) = 0;

  struct ResumeAnswer {
    bool accepted = false;
    std::string sentence;  ///< what was done, or why not
  };
  /// Hands the way back since the scan at T0, see CekfSlam::resume(); `elsewhere`: see
  /// CekfSlam::resumeElsewhere().
  virtual ResumeAnswer resume(double time_T0_s, const std::vector<PlaceAtScan>& path,
                              bool elsewhere) = 0;
};

}  // namespace hymm::core
