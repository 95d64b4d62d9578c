#pragma once

#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "perception/observation.h"

namespace hymm::core {

class LandmarkRegistry;
struct RegisteredLandmark;

/// The lasting error of the sightings of one landmark, if the filter holds one.
struct LastingErrorState {
  int slot = SparseMeasurement::kNone;
  Eigen::Vector2d seen_from = Eigen::Vector2d::Zero();  ///< where the sensor was then, map [m]

  bool exists() const { return slot != SparseMeasurement::kNone; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(slot, seen_from);
  }
};

/// Errors of range and bearing that last while a landmark is seen from much the same place: a
/// camera's of the height of a sign, a laser's of the shape of a trunk. Taken for noise that is
/// new in each scan, they would soon claim to be averaged out. Of an observation's covariance R
/// the shares s of range and bearing last,
///   R = C + (R - C),  C = L * L' = sqrt(s) * R * sqrt(s),
/// and the lasting part is L * u, u being a pair of states of the filter with the prior N(0, I). As
/// the view changes by dc, u goes on as a Gauss-Markov process: u <- a * u + noise, with
/// a = exp(-dc / view_change), dc being how far the sensor has moved, as a share of the range.
class LastingErrorModel {
 public:
  explicit LastingErrorModel(const LastingErrorConfig& config) : config_(config) {}

  /// Whether there are such errors.
  bool exist() const { return config_.range_share > 0.0 || config_.bearing_share > 0.0; }

  /// Of a landmark whose lasting error the filter holds: lets the error go on to where the sensor
  /// is now (map frame, m). Activates it.
  void goOn(const Eigen::Vector2d& sensor, RegisteredLandmark& landmark,
            CompressedEkf& filter) const;

  /// Lets a measurement depend on the error that the filter holds. `sighting`, the observation
  /// that it is of, becomes what it is for the estimate of that error.
  void include(const LastingErrorState& error, const CompressedEkf& filter, Observation& sighting,
               SparseMeasurement& measurement) const;

  /// L, and R - C.
  Eigen::Matrix2d factor(const Eigen::Matrix2d& covariance) const;
  Eigen::Matrix2d fresh(const Eigen::Matrix2d& covariance) const;

  /// a: how much of an error is left, from 1 to 0, when the sensor has gone from `before` to `now`.
  double kept(const Eigen::Vector2d& before, const Eigen::Vector2d& now,
              const Eigen::Vector2d& landmark) const;

 private:
  LastingErrorConfig config_;
};

/// Which landmarks' lasting errors the filter holds: of those that are in view.
class LastingErrors {
 public:
  /// A new error, independent of all there is. `sensor`: where it is in map [m].
  LastingErrorState add(int landmark_id, const Eigen::Vector2d& sensor, CompressedEkf& filter);
  /// Takes out of the filter the error of a landmark that goes.
  void remove(const RegisteredLandmark& landmark, CompressedEkf& filter);
  /// Takes out all errors of which nothing is left where the sensor is now.
  void removeForgotten(const Eigen::Vector2d& sensor, const LastingErrorModel& model,
                       LandmarkRegistry& registry, CompressedEkf& filter);
  void clear() { landmark_ids_.clear(); }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(landmark_ids_);
  }

 private:
  std::vector<int> landmark_ids_;
};

}  // namespace hymm::core
