#include "relocaliser/convergence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <Eigen/LU>

#include "common/chi_square.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Landmarks nearer to the edge of the view than this are not expected.
constexpr double kViewMargin_rad = 0.1;

// Scans after which a landmark counts as seen, or as never seen.
constexpr int kEnoughScans = 3;

// Stamps of a sensor's scans are not spaced to the bit.
constexpr double kSameTime_s = 1e-3;

/// Derivative of the place of a point by the pose that puts it there.
Eigen::Matrix<double, 2, 3> pointJacobian(const Pose2& pose, const Vector2d& p_local_point) {
  const Vector2d arm = p_local_point - pose.position();
  return (Eigen::Matrix<double, 2, 3>() << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x()).finished();
}

struct Nearest {
  const LocalLandmark* landmark = nullptr;
  double distance2 = std::numeric_limits<double>::infinity();
  Matrix2d independent = Matrix2d::Zero();  ///< covariance of landmark and observation
};

// A landmark is never told to be known better than this.
constexpr double kExact_m = 1e-4;

Nearest findNearest(const Vector2d& place, const Matrix2d& of_pose, double deviation_m,
                    const std::vector<LocalLandmark>& landmarks) {
  Nearest nearest;
  for (const LocalLandmark& landmark : landmarks) {
    const Matrix2d independent =
        landmark.covariance + deviation_m * deviation_m * Matrix2d::Identity();
    const Vector2d d = place - landmark.position;
    const double distance2 = d.dot((independent + of_pose).inverse() * d);
    if (distance2 < nearest.distance2) nearest = {&landmark, distance2, independent};
  }
  return nearest;
}

bool isExpected(const Pose2& T_local_sensor, const LocalLandmark& landmark,
                const SensorView& view) {
  const Vector2d p = inverse(T_local_sensor) * landmark.position;
  const double bearing = std::atan2(p.y(), p.x());
  return p.norm() <= view.range_m && p.norm() > 1.0 &&
         std::abs(bearing) <= view.field_of_view_rad / 2.0 - kViewMargin_rad;
}

}  // namespace

void ConvergenceConfig::describe(ConfigSchema& schema) {
  schema.number("propagation_factor", propagation_factor, Range{0.1, 100.0},
                "converged when deviations are under this times the motion's noise over 1 s ...");
  schema.number("information_factor", information_factor, Range{0.1, 100.0},
                "... or this times what one scan at that place can tell");
  schema.number("least_mode_share", least_mode_share, Range::between(0.5, 1.0),
                "weight that the one mode has to hold");
  schema.number("least_explained", least_explained, Range::between(0.0, 1.0),
                "share of the observations that landmarks have to explain");
  schema.number("most_missed", most_missed, Range::between(0.0, 1.0),
                "share of the landmarks that should have been seen and need not have been");
  schema.number("most_absent", most_absent, Range::between(0.0, 10.0),
                "landmarks that are never seen though they should be, for each that is seen");
  schema.integer("least_landmarks", least_landmarks, Range::between(2, 100),
                 "different landmarks that have to explain a scan");
  schema.number("gate_probability", gate_probability, Range::between(0.5, 0.999999),
                "chi-square gate of an observation and the landmark that explains it");
  schema.number("hold_s", hold_s, Range::between(0.0, 60.0),
                "time for which all this has to hold, scan after scan, three at least");
  schema.number("hold_way_m", hold_way_m, Range::between(0.0, 100.0),
                "way that is driven meanwhile: standing still, a vehicle learns nothing new");
  schema.number("rival_margin", rival_margin, Range::between(0.0, 1000.0),
                "log likelihood by which every other place has to explain the last scans worse");
}

Explanation explainScan(const Pose2& T_local_base, const Matrix3d& covariance,
                        const std::vector<ObservedPoint>& points,
                        const std::vector<LocalLandmark>& landmarks, const SensorView& view,
                        double gate_probability) {
  const double gate = chiSquareQuantile(gate_probability, 2);
  Explanation result;
  result.observations = static_cast<int>(points.size());
  std::set<int> seen;
  for (const ObservedPoint& point : points) {
    const Vector2d place = T_local_base * point.p_base_point.cast<double>();
    const auto J = pointJacobian(T_local_base, place);
    const Matrix2d of_pose = J * covariance * J.transpose();
    const Nearest nearest = findNearest(place, of_pose, point.deviation_m, landmarks);
    if (nearest.distance2 > gate) continue;
    ++result.explained;
    if (!seen.insert(nearest.landmark->id).second) continue;
    result.information += J.transpose() * nearest.independent.inverse() * J;
    result.of_points += J.transpose() * J / (point.deviation_m * point.deviation_m);
    const Matrix2d of_landmark =
        nearest.landmark->covariance + kExact_m * kExact_m * Matrix2d::Identity();
    result.of_landmarks += J.transpose() * of_landmark.inverse() * J;
  }
  result.seen.assign(seen.begin(), seen.end());
  const Pose2 T_local_sensor = T_local_base * view.T_base_sensor;
  for (const LocalLandmark& landmark : landmarks) {
    if (seen.count(landmark.id) == 0 && isExpected(T_local_sensor, landmark, view)) {
      result.missed.push_back(landmark.id);
    }
  }
  return result;
}

void HeldEvidence::clear() { *this = HeldEvidence(spacing_s_); }

void HeldEvidence::add(double time_s, const Explanation& explanation, double way_m) {
  if (scans_ == 0) first_s_ = time_s;
  last_s_ = time_s;
  way_m_ += way_m;
  const bool counts = scans_ == 0 || time_s - counted_s_ > spacing_s_ - kSameTime_s;
  ++scans_;
  if (!counts) return;
  counted_s_ = time_s;
  observations_ += explanation.observations;
  explained_ += explanation.explained;
  for (const int id : explanation.seen) ++landmarks_[id].seen;
  for (const int id : explanation.missed) ++landmarks_[id].missed;
}

double HeldEvidence::explainedShare() const {
  return observations_ > 0 ? static_cast<double>(explained_) / observations_ : 0.0;
}

int HeldEvidence::present() const {
  return static_cast<int>(
      std::count_if(landmarks_.begin(), landmarks_.end(), [](const auto& entry) {
        return entry.second.seen >= kEnoughScans && entry.second.seen > entry.second.missed;
      }));
}

int HeldEvidence::absent() const {
  return static_cast<int>(
      std::count_if(landmarks_.begin(), landmarks_.end(), [](const auto& entry) {
        return entry.second.missed >= kEnoughScans && entry.second.seen == 0;
      }));
}

Vector3d convergedDeviations(const Pose2& T_local_base, const Vector3d& motion_deviation,
                             const Matrix3d& information, const ConvergenceConfig& config) {
  const Matrix2d R = T_local_base.rotation();
  const Matrix2d moved = R * motion_deviation.head<2>().cwiseAbs2().asDiagonal() * R.transpose();
  Vector3d limit;
  limit << moved.diagonal().cwiseSqrt(), motion_deviation[2];
  limit *= config.propagation_factor;
  const Eigen::FullPivLU<Matrix3d> lu(information);
  if (!lu.isInvertible()) return limit;
  const Vector3d told = lu.inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
  return limit.cwiseMax(config.information_factor * told);
}

std::string findDoubt(const std::vector<ParticleMode>& modes, const Explanation& explanation,
                      const Vector3d& limit, const ConvergenceConfig& config) {
  if (modes.empty()) return "no particle explains the scan";
  if (modes.front().share < config.least_mode_share) return "there is more than one mode";
  const Vector3d deviation = modes.front().covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  if ((deviation.array() > limit.array()).any()) return "the particles are still spread";
  if (explanation.landmarks() < config.least_landmarks) return "too few landmarks are in view";
  const auto missed = static_cast<double>(explanation.missed.size());
  if (missed > config.most_missed * (missed + explanation.landmarks())) {
    return "landmarks that should be in view are not seen";
  }
  return {};
}

std::string findDoubt(const HeldEvidence& evidence, const ConvergenceConfig& config) {
  const bool is_short = evidence.lasting_s() < config.hold_s - kSameTime_s;
  if (is_short || evidence.way_m() < config.hold_way_m) {
    return "it has not held for long enough";
  }
  if (evidence.explainedShare() < config.least_explained) {
    return "the map does not explain what is seen";
  }
  if (evidence.present() < config.least_landmarks) return "too few landmarks are seen again";
  if (evidence.absent() > config.most_absent * evidence.present()) {
    return "landmarks that should be in view are never seen";
  }
  return {};
}

}  // namespace hymm::core
