#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.h"
#include "datasets/reading_count.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// Where the vehicle truly was, in the frame of the recording's reference.
struct TimedPose {
  double time_s = 0.0;
  Pose2 T_world_base;
};

/// Where a landmark truly is, in the frame of the recording's reference.
struct TruthLandmark {
  int identity = -1;  ///< as in Observation::identity
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();  ///< of the survey, m along x and y
};

/// A recording whose landmarks come as observations with identities instead of scans. The events
/// are in time order, ready for SensorMerger. Truth is empty where the recording has none; its
/// world frame is the reference's own, not the map that starts at the first pose.
struct LandmarkRecording {
  std::string name;
  std::vector<SensorEvent> events;
  std::vector<TimedPose> truth_poses;
  std::vector<TruthLandmark> truth_landmarks;
  std::vector<ReadingCount> counts;  ///< what was skipped, causes that did not occur left out
};

/// Deviations to give to the observations of MRCLAM, whose files state none. The defaults are the
/// deviations of (measured - truth) over the 4763 landmark observations of robots 1 and 2 of set 6
/// that have truth within 0.1 s.
struct MrclamNoise {
  double range_deviation_m = 0.17;
  double bearing_deviation_rad = 0.015;
};

/// Reads one robot of a UTIAS multi-robot set (MRCLAM) from its .zip or folder. Identities are
/// subject numbers, by Barcodes.dat. Observations of other robots (subjects 1 to 5) and of unknown
/// barcodes are skipped and counted. Times are the file's (Unix). Throws InputError.
LandmarkRecording readMrclam(const std::filesystem::path& path, int robot,
                             const MrclamNoise& noise = {});

/// Reads the DLR spatial-cognition recording (map.circles, or the folder that holds it). Throws
/// InputError.
///
/// The file has no clock and its odometry is displacements with covariances. Step k (from 0)
/// becomes a TwistInput stamped k * kDlrStep_s, which over kDlrStep_s moves the vehicle along an
/// arc by exactly the displacement, and whose `density` reproduces its covariance exactly
/// (MotionModel::step); the landmarks seen after it are stamped (k + 1) * kDlrStep_s. Observations
/// with several identities, or -1, come as not identified.
inline constexpr double kDlrStep_s = 0.25;
LandmarkRecording readDlr(const std::filesystem::path& path);

}  // namespace hymm::core
