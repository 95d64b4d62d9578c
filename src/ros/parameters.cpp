#include "ros/parameters.h"

#include <filesystem>
#include <iomanip>
#include <limits>
#include <sstream>

#include <ros/package.h>

namespace hymm {
namespace {

namespace fs = std::filesystem;

std::string exactText(double value) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::setprecision(std::numeric_limits<double>::max_digits10) << value;
  return stream.str();
}

/// What stands below `vehicle` in a vehicle's file; nothing after an error.
YAML::Node loadVehicleFile(const std::string& file, core::ConfigReport& report) {
  try {
    const YAML::Node content = YAML::LoadFile(file);
    if (content.IsMap() && content["vehicle"]) return content["vehicle"];
    report.errors.push_back(file + ": does not hold a group 'vehicle'.");
  } catch (const YAML::Exception& error) {
    report.errors.push_back(file + ": is not a readable YAML file: " + error.what() + ".");
  }
  return {};
}

std::string knownVehicles(const fs::path& folder) {
  std::string names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".yaml") continue;
    names += (names.empty() ? "" : ", ") + entry.path().stem().string();
  }
  return names.empty() ? "none" : names;
}

/// The file that a vehicle's name or path means; empty after an error.
std::string findVehicleFile(const std::string& name, const std::string& parameter,
                            core::ConfigReport& report) {
  const fs::path folder = fs::path(ros::package::getPath("hymm")) / "config" / "vehicles";
  const bool is_path = name.find('/') != std::string::npos || fs::path(name).extension() == ".yaml";
  const fs::path file = is_path ? fs::path(name) : folder / (name + ".yaml");
  if (fs::exists(file)) return file.string();
  report.errors.push_back(parameter + ": there is no vehicle '" + name + "': no file " +
                          file.string() + ". Known by name: " + knownVehicles(folder) + ".");
  return {};
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
      node = exactText(static_cast<double>(copy));
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

VehicleParameters readVehicle(const ros::NodeHandle& handle, core::ConfigReport& report) {
  VehicleParameters vehicle;
  std::string parameter;
  XmlRpc::XmlRpcValue value;
  if (!handle.searchParam("vehicle", parameter) || !handle.getParam(parameter, value)) {
    report.warnings.push_back(handle.getNamespace() +
                              ": there is no parameter 'vehicle' here or above; the built-in "
                              "vehicle is used. Load a dataset's YAML, or set 'vehicle' to a name "
                              "of config/vehicles.");
    return vehicle;
  }
  YAML::Node node = toYaml(value);
  std::string origin = parameter;
  if (node.IsScalar()) {
    origin = findVehicleFile(node.Scalar(), parameter, report);
    if (origin.empty()) return vehicle;
    node = loadVehicleFile(origin, report);
  }
  vehicle.tells_laser = node.IsMap() && node["laser"];
  core::readConfig(node, vehicle.config, origin, report);
  return vehicle;
}

}  // namespace hymm
