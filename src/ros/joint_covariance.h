#pragma once

#include <functional>
#include <string>
#include <vector>

#include <hymm/GetJointCovariance.h>

#include "cekf/landmark_map.h"

/// The service `get_joint_covariance`.
namespace hymm {

/// Why a request cannot be answered, as a sentence that names the ids; empty if it can.
std::string problemOf(const GetJointCovariance::Request& request,
                      const std::function<bool(int)>& is_landmark);

GetJointCovariance::Response toMessage(const core::JointLandmarks& joint,
                                       const std::string& frame_id);

}  // namespace hymm
