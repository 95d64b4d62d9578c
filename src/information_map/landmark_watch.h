#pragma once

#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "information_map/landmark_field.h"

namespace hymm::core {

/// A landmark that is not what it was when it was last told as changed.
struct ChangedLandmark {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< now, or of one that is gone, last [m]
  /// By how much a point of its region may have moved [m].
  double moved_m = 0.0;
  /// Largest change of its covariance, and of that relative to a neighbour, over what a
  /// measurement of it is uncertain by anyway.
  double changed = 0.0;
  bool is_new = false;
  bool is_gone = false;
};

/// Tells which landmarks changed by more than a tolerance since they were last told, so that small
/// changes add up and are told in the end.
class LandmarkWatch {
 public:
  struct Tolerance {
    double moved_m = 0.0;
    double changed = 0.0;
    double range_deviation_m = 0.0;  ///< of a measurement
    double region_sigmas = 0.0;
  };

  explicit LandmarkWatch(const Tolerance& tolerance) : tolerance_(tolerance) {}

  /// Changes from what was told so far to `field`.
  std::vector<ChangedLandmark> compare(const LandmarkField& field);

 private:
  struct Told {
    Eigen::Vector2d place;
    Eigen::Matrix2d covariance;
    Eigen::Matrix2d relative;  ///< to the neighbour that it had
    int neighbour_id = -1;
    std::uint64_t version_seen = 0;
  };
  Told describe(const LandmarkField& field, int index, int neighbour) const;
  ChangedLandmark changeOf(const Told& before, const Told& now) const;
  double relativeChange(const Eigen::Matrix2d& before, const Eigen::Matrix2d& now) const;

  Tolerance tolerance_;
  std::unordered_map<int, Told> told_;  ///< by id
  std::uint64_t comparisons_ = 0;
};

/// How the map moved between two versions: a place goes with the landmarks around it, each by the
/// inverse square of its distance.
class LandmarkMotion {
 public:
  LandmarkMotion(const LandmarkField& from, const LandmarkField& to, double range_m);

  /// Where a place of the old version is in the new one; itself where no landmark of both versions
  /// is within range.
  Eigen::Vector2d move(const Eigen::Vector2d& place) const;

  /// Largest displacement of a landmark of both versions [m].
  double largest_m() const { return largest_m_; }

 private:
  const LandmarkField& from_;
  std::vector<Eigen::Vector2d> displacement_;  ///< by landmark of from_; NaN if it is gone
  double range_m_;
  double largest_m_ = 0.0;
};

}  // namespace hymm::core
