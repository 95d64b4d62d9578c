#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <hymm/GetJointCovariance.h>

#include "cekf/landmark_map.h"
#include "relocaliser/filter_link.h"

/// The service `get_joint_covariance`.
namespace hymm {

/// Why a request cannot be answered, as a sentence that names the ids; empty if it can.
std::string problemOf(const GetJointCovariance::Request& request,
                      const std::function<bool(int)>& is_landmark);

GetJointCovariance::Response toMessage(const core::JointLandmarks& joint,
                                       const std::string& frame_id);
GetJointCovariance::Response toMessage(const core::FilterKnowledge& knowledge,
                                       const std::string& frame_id);

/// What an answer tells of the landmarks `ids` and the vehicle; nothing if its arrays have not the
/// sizes that this takes.
std::optional<core::FilterKnowledge> fromMessage(const GetJointCovariance::Response& message,
                                                 const std::vector<int>& ids);

}  // namespace hymm
