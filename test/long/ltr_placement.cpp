#include "ltr_placement.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <sstream>

#include <Eigen/Eigenvalues>

namespace hymm::core {
namespace {

constexpr double kRing_m = 10.0;  // distances are told apart in rings this wide

VehicleAmongLandmarks jointOf(CekfSlam& filter, const std::vector<int>& ids) {
  std::promise<VehicleAmongLandmarks> promise;
  const bool are_there = filter.requestVehicleAmongLandmarks(
      ids, [&](VehicleAmongLandmarks joint) { promise.set_value(std::move(joint)); });
  return are_there ? promise.get_future().get() : VehicleAmongLandmarks();
}

/// Of the error of a place that the vehicle sees, less the mean of the vertices' errors: the middle
/// of an LTR has the weights 1/3.
Eigen::Matrix2d relativeCovariance(const VehicleAmongLandmarks& joint,
                                   const Eigen::Vector2d& place) {
  const Eigen::Vector2d arm = place - joint.vehicle.mean.position();
  Eigen::Matrix<double, 2, 3> of_pose = Eigen::Matrix<double, 2, 3>::Zero();
  of_pose.leftCols<2>().setIdentity();
  of_pose.col(2) << -arm.y(), arm.x();
  Eigen::Matrix<double, 2, 6> of_vertices;
  for (int i = 0; i < 3; ++i) of_vertices.middleCols<2>(2 * i) = -Eigen::Matrix2d::Identity() / 3.0;
  Eigen::Matrix2d covariance = of_pose * joint.vehicle.covariance * of_pose.transpose() +
                               of_vertices * joint.landmarks.covariance * of_vertices.transpose();
  if (joint.cross_covariance.size() > 0) {
    const Eigen::Matrix2d cross = of_pose * joint.cross_covariance * of_vertices.transpose();
    covariance += cross + cross.transpose();
  }
  return covariance;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

void LtrPlacement::look(const HybridMap& map, CekfSlam& filter, const Pose2& T_map_base,
                        const Pose2& T_map_base_true, double range_m) {
  for (const LtrTopology& ltr : map.topology(LandmarkMap())) {
    const Corners corners = map.partition().mesh().corners(ltr.id);
    const Eigen::Vector2d place = (corners[0] + corners[1] + corners[2]) / 3.0;
    const double distance_m = (place - T_map_base.position()).norm();
    if (distance_m > range_m) continue;
    const auto joint = jointOf(filter, {ltr.landmark_ids.begin(), ltr.landmark_ids.end()});
    if (joint.landmarks.ids.size() != 3) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(relativeCovariance(joint, place));
    const Eigen::Vector2d seen = inverse(T_map_base) * place;
    looks_.push_back({distance_m, std::sqrt(std::max(0.0, axes.eigenvalues()[1])), ltr.landmark_ids,
                      place - T_map_base_true * seen, corners});
  }
}

std::string LtrPlacement::text(const std::string& prefix, const LandmarkMap& last,
                               const std::vector<TrueLandmark>& truth) const {
  constexpr double kSame_m = 0.5;
  std::map<int, Eigen::Vector2d> true_places;
  for (const LandmarkEstimate& landmark : last.landmarks) {
    const auto nearest = std::min_element(
        truth.begin(), truth.end(), [&](const TrueLandmark& a, const TrueLandmark& b) {
          return (a.position - landmark.position).norm() < (b.position - landmark.position).norm();
        });
    if ((nearest->position - landmark.position).norm() < kSame_m) {
      true_places[landmark.id] = nearest->position;
    }
  }
  std::ostringstream text;
  for (double from_m = 0.0; from_m < 3.0 * kRing_m; from_m += kRing_m) {
    std::vector<double> deviations, errors, in_map;
    for (const Look& look : looks_) {
      if (look.distance_m < from_m || look.distance_m >= from_m + kRing_m) continue;
      Eigen::Vector2d common = Eigen::Vector2d::Zero();
      std::size_t known = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto place = true_places.find(look.vertices[i]);
        if (place == true_places.end()) continue;
        common += (look.vertices_then[i] - place->second) / 3.0;
        ++known;
      }
      if (known < 3) continue;
      deviations.push_back(look.deviation_m);
      errors.push_back((look.place_error - common).norm());
      in_map.push_back(look.place_error.norm());
    }
    const std::string ring =
        "  \"" + prefix + "_to_" + std::to_string(static_cast<int>(from_m + kRing_m)) + "_m_";
    text << ring << "looks\": " << errors.size() << ",\n";
    for (const auto& [name, share] : {std::pair("median", 0.5), std::pair("p95", 0.95)}) {
      text << ring << "relative_deviation_" << name << "_m\": " << quantile(deviations, share)
           << ",\n"
           << ring << "relative_error_" << name << "_m\": " << quantile(errors, share) << ",\n"
           << ring << "error_in_map_" << name << "_m\": " << quantile(in_map, share) << ",\n";
    }
  }
  return text.str();
}

}  // namespace hymm::core
