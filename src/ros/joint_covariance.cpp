#include "ros/joint_covariance.h"

#include <set>

#include "ros/pose_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kMostLandmarks = 1000;  // 32 MB of covariance

std::string listed(const std::set<int>& ids) {
  std::string list;
  for (const int id : ids) list += (list.empty() ? "" : ", ") + std::to_string(id);
  return list;
}

std::vector<double> numbersOf(const RowMajor& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

}  // namespace

std::string problemOf(const GetJointCovariance::Request& request,
                      const std::function<bool(int)>& is_landmark) {
  if (request.ids.empty()) return "No landmark is named; give at least one id.";
  if (request.ids.size() > kMostLandmarks) {
    return std::to_string(request.ids.size()) + " landmarks are too many; ask for at most " +
           std::to_string(kMostLandmarks) + ".";
  }
  std::set<int> named, unknown, repeated;
  for (const int id : request.ids) {
    if (!is_landmark(id)) unknown.insert(id);
    if (!named.insert(id).second) repeated.insert(id);
  }
  if (!unknown.empty()) {
    return "There is no landmark " + listed(unknown) +
           " in the map; ids are those of the topic 'landmarks', which also tells merged ones.";
  }
  if (!repeated.empty()) {
    return "Asked for more than once: " + listed(repeated) + "; name each landmark once.";
  }
  return "";
}

GetJointCovariance::Response toMessage(const core::JointLandmarks& joint,
                                       const std::string& frame_id) {
  GetJointCovariance::Response message;
  message.success = 1U;
  message.message = "The joint estimate of " + std::to_string(joint.ids.size()) + " landmarks.";
  message.header.stamp = toRosTime(joint.time_s);
  message.header.frame_id = frame_id;
  message.version = joint.version;
  message.mean.assign(joint.mean.data(), joint.mean.data() + joint.mean.size());
  message.covariance = numbersOf(joint.covariance);
  return message;
}

GetJointCovariance::Response toMessage(const core::FilterKnowledge& knowledge,
                                       const std::string& frame_id) {
  const core::VehicleAmongLandmarks& estimate = knowledge.estimate;
  GetJointCovariance::Response message = toMessage(estimate.landmarks, frame_id);
  message.pose = toMessage(estimate.vehicle.mean, estimate.vehicle.covariance);
  message.pose_covariance = numbersOf(estimate.cross_covariance);
  Eigen::Map<Eigen::Vector3d>(message.calibration.data()) = knowledge.calibration.vector();
  return message;
}

std::optional<core::FilterKnowledge> fromMessage(const GetJointCovariance::Response& message,
                                                 const std::vector<int>& ids) {
  const std::size_t states = 2 * ids.size();
  if (message.mean.size() != states || message.covariance.size() != states * states ||
      message.pose_covariance.size() != 3 * states) {
    return std::nullopt;
  }
  const auto n = static_cast<Eigen::Index>(states);
  core::FilterKnowledge knowledge;
  core::VehicleAmongLandmarks& estimate = knowledge.estimate;
  estimate.landmarks.version = message.version;
  estimate.landmarks.time_s = message.header.stamp.toSec();
  estimate.landmarks.ids = ids;
  estimate.landmarks.mean = Eigen::Map<const Eigen::VectorXd>(message.mean.data(), n);
  estimate.landmarks.covariance = Eigen::Map<const RowMajor>(message.covariance.data(), n, n);
  estimate.vehicle = {fromMessage(message.pose.pose), planarCovariance(message.pose)};
  estimate.cross_covariance = Eigen::Map<const RowMajor>(message.pose_covariance.data(), 3, n);
  knowledge.calibration =
      core::Calibration::fromVector(Eigen::Map<const Eigen::Vector3d>(message.calibration.data()));
  return knowledge;
}

}  // namespace hymm
