#pragma once

#include <mutex>
#include <string>

#include <ros/node_handle.h>

#include "pipeline/landmark_mirror.h"
#include "relocaliser/filter_link.h"

namespace hymm {

/// Asks the node `cekf_slam`: its landmarks as it publishes them, the rest by its services. Calls
/// wait for the answer; not for the thread that receives messages.
class FilterServiceLink : public core::FilterLink {
 public:
  FilterServiceLink(ros::NodeHandle handle, std::string map_frame)
      : handle_(std::move(handle)), map_frame_(std::move(map_frame)) {}

  /// What the filter publishes; from any thread. False if changes in between are missing.
  void take(const core::LandmarkMap& map);
  bool take(const core::LandmarkUpdate& update);
  void hear(std::uint64_t version);
  void forgetLandmarks();
  bool hasLandmarks() const;

  std::vector<core::LandmarkEstimate> landmarks() override;
  std::string suspend(double time_T0_s) override;
  std::optional<core::FilterKnowledge> ask(const std::vector<int>& ids,
                                           std::string& problem) override;
  ResumeAnswer resume(double time_T0_s, const std::vector<core::PlaceAtScan>& path,
                      bool elsewhere) override;

 private:
  /// Why the call did not come to pass; empty if it was answered.
  template <class Service>
  std::string call(const std::string& name, Service& service);

  ros::NodeHandle handle_;
  std::string map_frame_;
  mutable std::mutex mutex_;
  core::LandmarkMirror mirror_;
};

}  // namespace hymm
