#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/vehicle_among_landmarks.h"
#include "common/config.h"
#include "common/pose2.h"

namespace hymm::core {

/// Which landmarks make the relocaliser's map.
struct LocalMapConfig {
  int max_landmarks = 40;
  double prior_deviations = 3.0;          ///< of the vehicle's place that the map has to cover
  double travel_m = 40.0;                 ///< that the vehicle may drive on meanwhile
  double max_landmark_deviation_m = 1.5;  ///< of the bound; what is known less tells nothing

  void describe(ConfigSchema& schema);
};

/// A landmark of a local map, independent of all others.
struct LocalLandmark {
  int id = -1;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();    ///< local frame, m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< a bound, m^2
};

/// Landmarks near the vehicle in the frame of two of them: the first is the origin, the x axis
/// leads to the second. Covariances are bounds: with all cross terms set to zero they are still
/// conservative for landmarks and vehicle together.
struct LocalMap {
  std::uint64_t version = 0;  ///< of the landmark map that it was made of
  Pose2 T_map_local;          ///< by the estimates of the two
  int origin_id = -1;
  int axis_id = -1;
  std::vector<LocalLandmark> landmarks;
  PosePrior vehicle;  ///< local frame
};

/// De-correlated map (36), (37) of at most `max_landmarks` within `range_m` of where the vehicle
/// may be or drive, in the frame of the two, of the half that is nearest, that make the trace of
/// the bounded map least. Where the vehicle is lost among some (by max_landmark_deviation_m), those
/// that came along with it are left out. Nothing, and the reason in `problem`, if fewer than two
/// landmarks are left, or the estimate is none (wrong sizes, not finite).
std::optional<LocalMap> tryMakeLocalMap(const VehicleAmongLandmarks& estimate, double range_m,
                                        const LocalMapConfig& config, std::string& problem);

/// Two landmarks that span a frame.
struct FrameChoice {
  int origin = 0;  ///< indices among the landmarks
  int axis = 1;
  double bounded_trace_m2 = 0.0;  ///< of the bound (37), k = 1, of all in that frame
};

/// Those two of `candidates` whose frame makes the trace of the bounded map least. `mean` holds x,
/// y of each landmark. Costs the square of the candidates times the square of the landmarks.
FrameChoice computeBestFrame(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                             const std::vector<int>& candidates);

/// Vehicle and landmarks in the frame of two of these, to first order: (36).
struct FramedEstimate {
  Pose2 T_map_local;
  Eigen::VectorXd mean;        ///< pose (x, y, yaw), then x, y of each landmark
  Eigen::MatrixXd covariance;  ///< of the same
};

/// `mean` and `covariance` are of the pose (x, y, yaw), then of x, y of each landmark, map frame.
FramedEstimate expressInFrame(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                              int origin, int axis);

}  // namespace hymm::core
