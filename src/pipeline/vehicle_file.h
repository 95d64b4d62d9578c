#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <yaml-cpp/yaml.h>

#include "common/config.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// A vehicle, and whether its description tells where the laser stands.
struct VehicleDescription {
  VehicleConfig config;
  bool tells_laser = false;
};

/// Where a configuration that names a vehicle stands, and where vehicles are looked for.
struct VehiclePlaces {
  std::string origin;            ///< of the name, as sentences about it begin
  std::filesystem::path folder;  ///< of the file that names it; empty: it stands in no file
  /// The package's folder `config`; asked only where it is needed; empty: there is none.
  std::function<std::string()> findConfigFolder;
};

/// Whether the content of a YAML file tells where its vehicle's laser stands.
bool tellsLaser(const YAML::Node& content);

/// The vehicle that a configuration gives as a text. A path (it ends in .yaml or holds a slash) is
/// relative to the folder of the file that names it, else to the package's `config`. A name means
/// ../vehicles/NAME.yaml beside that file, else vehicles/NAME.yaml in the package's `config`.
/// Nothing where no such file can be read: the report says why.
std::optional<VehicleDescription> readNamedVehicle(const std::string& name,
                                                   const VehiclePlaces& places,
                                                   ConfigReport& report);

/// A YAML file; nothing where it cannot be read: the report says why.
std::optional<YAML::Node> readYamlFile(const std::string& file, ConfigReport& report);

}  // namespace hymm::core
