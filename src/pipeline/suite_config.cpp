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

using FolderFinder = std::function<std::string()>;

bool isPath(const std::string& vehicle) {
  return fs::path(vehicle).extension() == ".yaml" || vehicle.find('/') != std::string::npos;
}

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::optional<fs::path> findVehicle(const std::string& name, const fs::path& naming_file,
                                    const FolderFinder& findConfigFolder, ConfigReport& report) {
  const fs::path folder = naming_file.parent_path();
  // operator/ keeps an absolute path as it is.
  const fs::path near =
      isPath(name) ? folder / name : folder / ".." / "vehicles" / (name + ".yaml");
  if (isFile(near)) return near.lexically_normal();
  std::string tried = near.lexically_normal().string();
  const bool may_be_shipped = !isPath(name) && findConfigFolder != nullptr;
  if (const fs::path config = may_be_shipped ? findConfigFolder() : ""; !config.empty()) {
    const fs::path shipped = config / "vehicles" / (name + ".yaml");
    if (isFile(shipped)) return shipped;
    tried += " and " + shipped.string();
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

bool tellsLaser(const YAML::Node& file) {
  return file.IsMap() && file["vehicle"] && file["vehicle"].IsMap() && file["vehicle"]["laser"];
}

void loadVehicle(const fs::path& file, SuiteConfig& config, ConfigReport& report) {
  const std::optional<YAML::Node> node = readYamlFile(file.string(), report);
  if (!node) return;
  if (!node->IsMap() || !(*node)["vehicle"]) {
    report.errors.push_back(file.string() + ": does not hold a group 'vehicle'.");
    return;
  }
  VehicleFile content;
  readConfig(*node, content, file.string(), report);
  config.vehicle = content.vehicle;
  config.vehicle_tells_laser = tellsLaser(*node);
}

}  // namespace

void SuiteConfig::describe(ConfigSchema& schema) {
  schema.group("vehicle", vehicle);
  schema.group("cekf_slam", cekf_slam);
  schema.group("dead_reckoning", dead_reckoning);
  schema.group("supervisor", supervisor);
}

SuiteConfig loadSuiteConfig(const std::vector<std::string>& files, ConfigReport& report,
                            const FolderFinder& findConfigFolder) {
  SuiteConfig config;
  for (const std::string& file : files) {
    std::optional<YAML::Node> node = readYamlFile(file, report);
    if (!node) continue;
    if (node->IsMap() && (*node)["vehicle"] && (*node)["vehicle"].IsScalar()) {
      const std::string name = (*node)["vehicle"].Scalar();
      if (const auto place = findVehicle(name, file, findConfigFolder, report)) {
        loadVehicle(*place, config, report);
      }
      node->remove("vehicle");
    }
    config.vehicle_tells_laser = config.vehicle_tells_laser || tellsLaser(*node);
    readConfig(*node, config, file, report);
  }
  return config;
}

}  // namespace hymm::core
