#include "ros/joint_covariance.h"

#include <set>

#include "ros/time_conversions.h"

namespace hymm {
namespace {

constexpr std::size_t kMostLandmarks = 1000;  // 32 MB of covariance

std::string listed(const std::set<int>& ids) {
  std::string list;
  for (const int id : ids) list += (list.empty() ? "" : ", ") + std::to_string(id);
  return list;
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
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const RowMajor covariance = joint.covariance;
  message.covariance.assign(covariance.data(), covariance.data() + covariance.size());
  return message;
}

}  // namespace hymm
