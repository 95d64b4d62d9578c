#pragma once

#include <ros/node_handle.h>

#include "common/config.h"
#include "pipeline/vehicle_file.h"

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

/// The package's folder of configurations; empty where the package is not found.
std::string configFolder();

/// The parameter `vehicle`, searched from the handle's namespace upwards: a group of parameters, or
/// the text that names a vehicle, as offline (see core::readNamedVehicle). The file that names it
/// is the parameter `config_file` beside it, which the launch files set. Where there is no
/// `vehicle`, a warning and the built-in one.
core::VehicleDescription readVehicle(const ros::NodeHandle& handle, core::ConfigReport& report);

}  // namespace hymm
