#include "pipeline/suite_config.h"

#include <filesystem>
#include <optional>

#include "pipeline/vehicle_file.h"

namespace hymm::core {

namespace {

std::filesystem::path folderOf(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

}  // namespace

void SuiteConfig::describe(ConfigSchema& schema) {
  schema.group("vehicle", vehicle);
  schema.group("point_clouds", point_clouds);
  schema.group("cekf_slam", cekf_slam);
  schema.group("dead_reckoning", dead_reckoning);
  schema.group("hymm_grid", hymm_grid);
  schema.group("information_map", information_map);
  schema.group("door_planner", door_planner);
  schema.group("relocaliser", relocaliser);
  schema.group("supervisor", supervisor);
}

SuiteConfig loadSuiteConfig(const std::vector<std::string>& files, ConfigReport& report,
                            const std::function<std::string()>& findConfigFolder) {
  SuiteConfig config;
  for (const std::string& file : files) {
    std::optional<YAML::Node> node = readYamlFile(file, report);
    if (!node) continue;
    if (node->IsMap() && (*node)["vehicle"] && (*node)["vehicle"].IsScalar()) {
      const VehiclePlaces places{file, folderOf(file), findConfigFolder};
      if (const auto vehicle = readNamedVehicle((*node)["vehicle"].Scalar(), places, report)) {
        config.vehicle = vehicle->config;
        config.vehicle_tells_laser = vehicle->tells_laser;
      }
      node->remove("vehicle");
    }
    config.vehicle_tells_laser = config.vehicle_tells_laser || tellsLaser(*node);
    readConfig(*node, config, file, report);
  }
  return config;
}

}  // namespace hymm::core
