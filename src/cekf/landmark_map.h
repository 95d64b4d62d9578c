#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "perception/observation.h"

namespace hymm::core {

/// A landmark as the filter estimates it, in the map frame.
struct LandmarkEstimate {
  int id = -1;
  LandmarkType type = LandmarkType::kUnknown;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();        ///< m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< m^2
  double diameter_m = 0.0;                                   ///< NaN where unknown
  double diameter_variance = 0.0;                            ///< m^2, NaN where unknown
  int observations = 0;                                      ///< that updated it
  double last_seen_s = 0.0;
  double first_seen_s = 0.0;  ///< stamp of the scan that put it into the map
};

/// Covariance between two landmarks, rows of the first, columns of the second.
struct CrossCovariance {
  int first_id = -1;
  int second_id = -1;
  Eigen::Matrix2d block = Eigen::Matrix2d::Zero();
};

/// `from` was found to be the same object as `into`, and exists no more.
struct LandmarkMerge {
  int from_id = -1;
  int into_id = -1;
};

/// All landmarks at one moment of the filter (one epoch). Sorted by id.
struct LandmarkMap {
  std::uint64_t version = 0;  ///< grows with each change
  double time_s = 0.0;
  std::vector<LandmarkEstimate> landmarks;
  std::vector<LandmarkMerge> merges;               ///< all since the start
  std::vector<CrossCovariance> cross_covariances;  ///< pairs within the range asked for
};

/// Several landmarks, jointly.
struct JointLandmarks {
  std::uint64_t version = 0;
  double time_s = 0.0;
  std::vector<int> ids;
  Eigen::VectorXd mean;        ///< x, y of each in turn, m
  Eigen::MatrixXd covariance;  ///< m^2
};

/// What changed between two versions of the map.
struct LandmarkUpdate {
  std::uint64_t since_version = 0;
  std::uint64_t version = 0;
  std::vector<LandmarkEstimate> changed;  ///< new, or active in the filter
  std::vector<int> removed_ids;
  std::vector<LandmarkMerge> merges;
};

}  // namespace hymm::core
