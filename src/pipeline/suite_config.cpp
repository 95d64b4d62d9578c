#include "pipeline/suite_config.h"

#include <filesystem>
#include <optional>

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

std::optional<YAML::Node> readYamlFile(const std::string& file, ConfigReport& report) {
  try {
    return YAML::LoadFile(file);
  } catch (const YAML::BadFile&) {
    report.errors.push_back(file + ": cannot be opened; is the path right?");
  } catch (const YAML::Exception& error) {
    report.errors.push_back(file + ": is not valid YAML: " + error.what());
  }
  return std::nullopt;
}

/// Where a vehicle's file may be, the most specific place first.
std::vector<fs::path> vehiclePlaces(const std::string& name, const fs::path& naming_file,
                                    const std::string& config_folder) {
  const fs::path folder = naming_file.parent_path();
  if (fs::path(name).extension() == ".yaml" || name.find('/') != std::string::npos) {
    return {folder / name};  // operator/ keeps an absolute path as it is
  }
  std::vector<fs::path> places = {folder / ".." / "vehicles" / (name + ".yaml")};
  if (!config_folder.empty()) {
    places.push_back(fs::path(config_folder) / "vehicles" / (name + ".yaml"));
  }
  return places;
}

std::optional<fs::path> findVehicle(const std::string& name, const fs::path& naming_file,
                                    const std::string& config_folder, ConfigReport& report) {
  const std::vector<fs::path> places = vehiclePlaces(name, naming_file, config_folder);
  std::string tried;
  for (const fs::path& place : places) {
    std::error_code ignored;
    if (fs::is_regular_file(place, ignored)) return place.lexically_normal();
    tried += (tried.empty() ? "" : ", ") + place.lexically_normal().string();
  }
  report.errors.push_back(naming_file.string() + ": vehicle '" + name +
                          "' is not found; looked for " + tried + ".");
  return std::nullopt;
}

/// A file of config/vehicles holds `vehicle` and nothing else.
struct VehicleFile {
  VehicleConfig vehicle;
  void describe(ConfigSchema& schema) { schema.group("vehicle", vehicle); }
};

VehicleConfig loadVehicle(const fs::path& file, ConfigReport& report) {
  VehicleFile content;
  const std::optional<YAML::Node> node = readYamlFile(file.string(), report);
  if (!node) return content.vehicle;
  if (!node->IsMap() || !(*node)["vehicle"]) {
    report.errors.push_back(file.string() + ": does not hold a group 'vehicle'.");
    return content.vehicle;
  }
  readConfig(*node, content, file.string(), report);
  return content.vehicle;
}

}  // namespace

void SuiteConfig::describe(ConfigSchema& schema) {
  schema.group("vehicle", vehicle);
  schema.group("cekf_slam", cekf_slam);
}

SuiteConfig loadSuiteConfig(const std::vector<std::string>& files, const std::string& config_folder,
                            ConfigReport& report) {
  SuiteConfig config;
  for (const std::string& file : files) {
    std::optional<YAML::Node> node = readYamlFile(file, report);
    if (!node) continue;
    if (node->IsMap() && (*node)["vehicle"] && (*node)["vehicle"].IsScalar()) {
      const std::string name = (*node)["vehicle"].Scalar();
      if (const auto place = findVehicle(name, file, config_folder, report)) {
        config.vehicle = loadVehicle(*place, report);
      }
      node->remove("vehicle");
    }
    readConfig(*node, config, file, report);
  }
  return config;
}

}  // namespace hymm::core
