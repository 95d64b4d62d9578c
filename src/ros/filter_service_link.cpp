#include "ros/filter_service_link.h"

#include <hymm/GetJointCovariance.h>
#include <hymm/Resume.h>
#include <hymm/Suspend.h>
#include <ros/service.h>

#include "ros/joint_covariance.h"
#include "ros/relocaliser_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {

void FilterServiceLink::take(const core::LandmarkMap& map) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mirror_.take(map);
}

bool FilterServiceLink::take(const core::LandmarkUpdate& update) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return mirror_.take(update);
}

void FilterServiceLink::hear(std::uint64_t version) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mirror_.hear(version);
}

void FilterServiceLink::forgetLandmarks() {
  const std::lock_guard<std::mutex> lock(mutex_);
  mirror_ = core::LandmarkMirror();
}

bool FilterServiceLink::hasLandmarks() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !mirror_.map().landmarks.empty();
}

std::vector<core::LandmarkEstimate> FilterServiceLink::landmarks() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return mirror_.map().landmarks;
}

template <class Service>
std::string FilterServiceLink::call(const std::string& name, Service& service) {
  if (ros::service::call(handle_.resolveName(name), service)) return "";
  return "The service '" + handle_.resolveName(name) + "' does not answer; does cekf_slam run?";
}

std::string FilterServiceLink::suspend(double time_T0_s) {
  Suspend service;
  service.request.since = toRosTime(time_T0_s);
  const std::string problem = call("suspend", service);
  if (!problem.empty()) return problem;
  return service.response.success != 0U ? "" : service.response.message;
}

std::optional<core::FilterKnowledge> FilterServiceLink::ask(const std::vector<int>& ids,
                                                            std::string& problem) {
  GetJointCovariance service;
  service.request.ids.assign(ids.begin(), ids.end());
  service.request.vehicle = 1U;
  problem = call("get_joint_covariance", service);
  if (!problem.empty()) return std::nullopt;
  if (service.response.success == 0U) {
    problem = service.response.message;
    return std::nullopt;
  }
  std::optional<core::FilterKnowledge> knowledge = fromMessage(service.response, ids);
  if (!knowledge) problem = "The answer of 'get_joint_covariance' has arrays of the wrong size.";
  return knowledge;
}

core::FilterLink::ResumeAnswer FilterServiceLink::resume(double time_T0_s,
                                                         const std::vector<core::PlaceAtScan>& path,
                                                         bool elsewhere) {
  Resume service;
  service.request.way = elsewhere ? Resume::Request::ELSEWHERE : Resume::Request::CLOSING;
  service.request.since = toRosTime(time_T0_s);
  service.request.path = toMessage(path, map_frame_);
  const std::string problem = call("resume", service);
  if (!problem.empty()) return {false, problem};
  return {service.response.success != 0U, service.response.message};
}

}  // namespace hymm
