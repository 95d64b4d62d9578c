#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cekf/cekf_slam_config.h"
#include "common/config.h"
#include "door_planner/door_planner_config.h"
#include "information_map/information_map_config.h"
#include "perception/point_scan.h"
#include "pipeline/hymm_grid_config.h"
#include "relocaliser/relocaliser_config.h"
#include "supervisor/supervisor_decision.h"
#include "vehicle/dead_reckoning_config.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// Everything that a run of the suite can be told, as YAML holds it: the top-level names are
/// `vehicle`, `point_clouds` and the names of the nodes. Default-constructed: the built-in
/// defaults.
struct SuiteConfig {
  VehicleConfig vehicle;
  PointCloudConfig point_clouds;  ///< for all that take clouds
  CekfSlamConfig cekf_slam;
  DeadReckoningConfig dead_reckoning;
  HymmGridConfig hymm_grid;
  InformationMapConfig information_map;
  DoorPlannerConfig door_planner;
  RelocaliserConfig relocaliser;
  SupervisorConfig supervisor;
  bool vehicle_tells_laser = false;  ///< whether a file said where the laser stands

  void describe(ConfigSchema& schema);
};

/// Reads YAML files in order over the built-in defaults; a later file overrides single parameters
/// of the earlier ones. `vehicle` is either a group of parameters or a text, which names a vehicle
/// as readNamedVehicle() says and replaces whatever vehicle came before. `findConfigFolder`: see
/// VehiclePlaces.
///
/// Problems are collected in `report`, each led by the file it stands in: a file that cannot be
/// read, a vehicle that cannot be found, wrong types and values out of range are errors; unknown
/// names are warnings. The result is usable when there are no errors.
SuiteConfig loadSuiteConfig(const std::vector<std::string>& files, ConfigReport& report,
                            const std::function<std::string()>& findConfigFolder = nullptr);

}  // namespace hymm::core
