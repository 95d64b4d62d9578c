#pragma once

#include <ros/node_handle.h>

#include "common/config.h"
#include "vehicle/vehicle_config.h"

/// ROS parameters through the same descriptions as YAML files, so that both know the same names,
/// ranges and sentences.
namespace hymm {

/// A parameter tree as YAML. Numbers keep every digit.
YAML::Node toYaml(const XmlRpc::XmlRpcValue& value);

/// All parameters in the handle's namespace; an empty map if there are none.
YAML::Node parameterTree(const ros::NodeHandle& handle);

/// Overwrites what the handle's (private) namespace holds. A nested `vehicle` is left to
/// readVehicle().
template <class Config>
void readParameters(const ros::NodeHandle& handle, Config& config, core::ConfigReport& report) {
  YAML::Node tree = parameterTree(handle);
  tree.remove("vehicle");
  core::readConfig(tree, config, handle.getNamespace(), report);
}

/// A vehicle, and whether its description tells where the laser stands.
struct VehicleParameters {
  core::VehicleConfig config;
  bool tells_laser = false;
};

/// The parameter `vehicle`, searched from the handle's namespace upwards: a group of parameters, or
/// the name of a file config/vehicles/NAME.yaml of this package, or the path of such a file. Where
/// there is none, a warning and the built-in vehicle.
VehicleParameters readVehicle(const ros::NodeHandle& handle, core::ConfigReport& report);

}  // namespace hymm
