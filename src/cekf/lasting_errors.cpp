#include "cekf/lasting_errors.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "cekf/landmark_registry.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

// An error of which less is kept is as good as a new one.
constexpr double kForgotten = 0.05;

}  // namespace

double LastingErrorModel::kept(const Vector2d& before, const Vector2d& now,
                               const Vector2d& landmark) const {
  const double range_m = std::min((before - landmark).norm(), (now - landmark).norm());
  const double way_m = (now - before).norm();
  return way_m > 0.0 ? std::exp(-way_m / (range_m * config_.view_change)) : 1.0;
}

Matrix2d LastingErrorModel::factor(const Matrix2d& covariance) const {
  const Vector2d root(std::sqrt(config_.range_share), std::sqrt(config_.bearing_share));
  const Matrix2d L = covariance.llt().matrixL();
  return root.asDiagonal() * L;
}

Matrix2d LastingErrorModel::fresh(const Matrix2d& covariance) const {
  const Matrix2d L = factor(covariance);
  return covariance - L * L.transpose();
}

void LastingErrorModel::goOn(const Vector2d& sensor, RegisteredLandmark& landmark,
                             CompressedEkf& filter) const {
  LastingErrorState& error = landmark.lasting_error;
  filter.activate(error.slot);
  filter.fade(error.slot, kept(error.seen_from, sensor, landmark.position), Matrix2d::Identity());
  error.seen_from = sensor;
}

void LastingErrorModel::include(const LastingErrorState& error, const CompressedEkf& filter,
                                Observation& sighting, SparseMeasurement& measurement) const {
  const Matrix2d L = factor(sighting.covariance);
  const Vector2d estimate = L * filter.landmark(error.slot);
  sighting.range_m -= estimate[0];
  sighting.bearing_rad -= estimate[1];
  sighting.covariance = fresh(sighting.covariance);
  measurement.innovation -= estimate;
  measurement.noise = sighting.covariance;
  measurement.landmarks[SparseMeasurement::kError] = error.slot;
  measurement.H_landmarks[SparseMeasurement::kError] = L;
}

LastingErrorState LastingErrors::add(int landmark_id, const Vector2d& sensor,
                                     CompressedEkf& filter) {
  landmark_ids_.push_back(landmark_id);
  return {filter.appendQuantities(Vector2d::Zero(), Matrix2d::Identity()), sensor};
}

void LastingErrors::remove(const RegisteredLandmark& landmark, CompressedEkf& filter) {
  if (!landmark.lasting_error.exists()) return;
  filter.remove(landmark.lasting_error.slot);
  landmark_ids_.erase(std::find(landmark_ids_.begin(), landmark_ids_.end(), landmark.id));
}

void LastingErrors::removeForgotten(const Vector2d& sensor, const LastingErrorModel& model,
                                    LandmarkRegistry& registry, CompressedEkf& filter) {
  const auto is_forgotten = [&](int id) {
    RegisteredLandmark& landmark = registry.byId(id);
    const double kept = model.kept(landmark.lasting_error.seen_from, sensor, landmark.position);
    if (kept > kForgotten) return false;
    filter.remove(landmark.lasting_error.slot);
    landmark.lasting_error = {};
    return true;
  };
  landmark_ids_.erase(std::remove_if(landmark_ids_.begin(), landmark_ids_.end(), is_forgotten),
                      landmark_ids_.end());
}

}  // namespace hymm::core
