#include "ros/parameters.h"

#include <filesystem>

#include <ros/names.h>
#include <ros/package.h>

#include "common/number_text.h"

namespace hymm {
namespace {

/// The folder of the file out of which the launch file loaded `parameter`; empty if none tells.
std::filesystem::path overlayFolder(const ros::NodeHandle& handle, const std::string& parameter) {
  std::string file;
  handle.getParam(ros::names::append(ros::names::parentNamespace(parameter), "config_file"), file);
  return std::filesystem::path(file).parent_path();
}

}  // namespace

YAML::Node toYaml(const XmlRpc::XmlRpcValue& value) {
  XmlRpc::XmlRpcValue copy = value;  // its accessors are not const
  YAML::Node node;
  switch (copy.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      node = static_cast<bool>(copy);
      break;
    case XmlRpc::XmlRpcValue::TypeInt:
      node = static_cast<int>(copy);
      break;
    case XmlRpc::XmlRpcValue::TypeDouble:
      node = core::numberText(static_cast<double>(copy));
      break;
    case XmlRpc::XmlRpcValue::TypeString:
      node = static_cast<std::string>(copy);
      break;
    case XmlRpc::XmlRpcValue::TypeArray:
      node = YAML::Node(YAML::NodeType::Sequence);
      for (int i = 0; i < copy.size(); ++i) node.push_back(toYaml(copy[i]));
      break;
    case XmlRpc::XmlRpcValue::TypeStruct:
      node = YAML::Node(YAML::NodeType::Map);
      for (auto& member : copy) node[member.first] = toYaml(member.second);
      break;
    default:
      break;  // dates and binary data have no meaning here; the reader says that a value is missing
  }
  return node;
}

YAML::Node parameterTree(const ros::NodeHandle& handle) {
  XmlRpc::XmlRpcValue value;
  if (!handle.getParam(handle.getNamespace(), value)) return YAML::Node(YAML::NodeType::Map);
  return toYaml(value);
}

std::string configFolder() {
  const std::string package = ros::package::getPath("hymm");
  return package.empty() ? "" : package + "/config";
}

core::VehicleDescription readVehicle(const ros::NodeHandle& handle, core::ConfigReport& report) {
  core::VehicleDescription vehicle;
  std::string parameter;
  XmlRpc::XmlRpcValue value;
  if (!handle.searchParam("vehicle", parameter) || !handle.getParam(parameter, value)) {
    report.warnings.push_back(handle.getNamespace() +
                              ": there is no parameter 'vehicle' here or above; the built-in "
                              "vehicle is used. Give the launch file a YAML file (config:=) that "
                              "has a 'vehicle', or names one of config/vehicles.");
    return vehicle;
  }
  const YAML::Node node = toYaml(value);
  if (node.IsScalar()) {
    const core::VehiclePlaces places{parameter, overlayFolder(handle, parameter), configFolder};
    return core::readNamedVehicle(node.Scalar(), places, report).value_or(vehicle);
  }
  vehicle.tells_laser = node.IsMap() && node["laser"];
  core::readConfig(node, vehicle.config, parameter, report);
  return vehicle;
}

}  // namespace hymm
