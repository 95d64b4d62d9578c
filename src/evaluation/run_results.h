#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cekf/landmark_map.h"
#include "evaluation/gps_error.h"
#include "evaluation/pose_error.h"

namespace hymm::core {

/// Normalised innovation squared of one scan.
struct StampedNis {
  double time_s = 0.0;
  double nis = 0.0;
  int dof = 0;
};

/// What a folder of results holds (see ResultsWriter) of the last map of its run: poses before a
/// reset are in another map frame than the landmarks, and are left out.
struct RunResults {
  std::vector<UncertainPose> poses;
  std::vector<StampedNis> nis;
  std::vector<LandmarkEstimate> landmarks;
  std::vector<StampedPosition> gps;            ///< local east-north frame
  std::optional<Eigen::Vector2d> gps_antenna;  ///< place in base_link
  std::size_t resets = 0;
};

/// Throws InputError if a file is missing or cannot be understood.
RunResults readRunResults(const std::string& folder);

/// Fixes of a file: a CSV with columns t, x, y, or rows of numbers without a header in ACFR's
/// order: time, latitude (north), longitude (east), both in metres. Throws InputError.
std::vector<StampedPosition> readFixes(const std::string& file);

/// Surveyed landmarks of a CSV file with columns x, y [m]; others are ignored. Throws InputError.
std::vector<Eigen::Vector2d> readSurvey(const std::string& file);

}  // namespace hymm::core
