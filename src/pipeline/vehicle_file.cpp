#include "pipeline/vehicle_file.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <vector>

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

/// What a vehicle's file holds: `vehicle` and nothing else.
struct VehicleFile {
  VehicleConfig vehicle;
  void describe(ConfigSchema& schema) { schema.group("vehicle", vehicle); }
};

bool isPath(const std::string& vehicle) {
  return fs::path(vehicle).extension() == ".yaml" || vehicle.find('/') != std::string::npos;
}

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::string knownVehicles(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

std::optional<fs::path> findVehicle(const std::string& name, const VehiclePlaces& places,
                                    ConfigReport& report) {
  const bool is_path = isPath(name), is_absolute = fs::path(name).is_absolute();
  const fs::path shipped = is_path ? fs::path(name) : fs::path("vehicles") / (name + ".yaml");
  const fs::path near = is_path ? shipped : ".." / shipped;
  std::string tried, known;
  const auto isThere = [&](const fs::path& file) {
    tried += (tried.empty() ? "" : " and ") + file.string();
    return isFile(file);
  };
  if (is_absolute || !places.folder.empty()) {  // operator/ keeps an absolute path as it is
    const fs::path file = (places.folder / near).lexically_normal();
    if (isThere(file)) return file;
  }
  const fs::path config =
      places.findConfigFolder && !is_absolute ? places.findConfigFolder() : std::string();
  if (!config.empty()) {
    if (isThere(config / shipped)) return config / shipped;
    known = " Known by name: " + knownVehicles(config / "vehicles") + ".";
  }
  report.errors.push_back(places.origin + ": vehicle '" + name + "' is not found; looked for " +
                          (tried.empty() ? "nothing: no folder is known" : tried) + "." + known);
  return std::nullopt;
}

/// YAML forbids it, and its reader takes either. An alias may lead back to what holds it.
std::optional<std::string> findNameGivenTwice(const YAML::Node& node, int depth) {
  constexpr int kDeepest = 8;
  if (!node.IsMap() || depth > kDeepest) return std::nullopt;
  std::set<std::string> names;
  for (const auto& item : node) {
    if (!item.first.IsScalar()) continue;
    const std::string& name = item.first.Scalar();
    if (!names.insert(name).second) return "'" + name + "'";
    const std::optional<std::string> inside = findNameGivenTwice(item.second, depth + 1);
    if (inside) return "'" + name + "." + inside->substr(1);
  }
  return std::nullopt;
}

}  // namespace

bool tellsLaser(const YAML::Node& content) {
  return content.IsMap() && content["vehicle"] && content["vehicle"].IsMap() &&
         content["vehicle"]["laser"];
}

std::optional<VehicleDescription> readNamedVehicle(const std::string& name,
                                                   const VehiclePlaces& places,
                                                   ConfigReport& report) {
  const std::optional<fs::path> file = findVehicle(name, places, report);
  if (!file) return std::nullopt;
  const std::optional<YAML::Node> content = readYamlFile(file->string(), report);
  if (!content) return std::nullopt;
  if (!content->IsMap() || !(*content)["vehicle"]) {
    report.errors.push_back(file->string() + ": does not hold a group 'vehicle'.");
    return std::nullopt;
  }
  VehicleFile vehicle;
  readConfig(*content, vehicle, file->string(), report);
  return VehicleDescription{vehicle.vehicle, tellsLaser(*content)};
}

std::optional<YAML::Node> readYamlFile(const std::string& file, ConfigReport& report) {
  std::error_code problem;
  if (fs::is_directory(file, problem)) {
    report.errors.push_back(file + ": is a folder; a YAML file is needed.");
    return std::nullopt;
  }
  try {
    YAML::Node content = YAML::LoadFile(file);
    const std::optional<std::string> twice = findNameGivenTwice(content, 0);
    if (!twice) return content;
    report.errors.push_back(file + ": " + *twice + " is given twice; keep one of them.");
  } catch (const YAML::BadFile&) {
    report.errors.push_back(file + ": cannot be opened; is the path right?");
  } catch (const YAML::Exception& error) {
    report.errors.push_back(file + ": is not valid YAML: " + error.what());
  }
  return std::nullopt;
}

}  // namespace hymm::core
