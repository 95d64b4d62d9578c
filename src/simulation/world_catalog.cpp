#include "simulation/world_catalog.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace hymm::core {
namespace {

std::string shortNumber(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 2);
}

/// A car that follows a curve needs some steering in hand.
void refuseTooTight(const Route& route, const VehicleConfig& vehicle, const std::string& world) {
  const double tightest = 1.0 / route.greatestCurvature();
  const double possible = vehicle.ackermann.wheelbase_m / std::tan(0.95 * vehicle.max_steering_rad);
  if (tightest >= possible) return;
  throw ConfigError({"simulation: the vehicle's smallest turning radius is " +
                     shortNumber(possible) + " m, but world '" + world + "' has curves of " +
                     shortNumber(tightest) +
                     " m; check wheelbase_m and max_steering_rad, or choose another world."});
}

}  // namespace

const std::vector<WorldKind>& worldCatalog() {
  static const std::vector<WorldKind> kinds = {
      {"park", "scattered trees, bushes, shelters and people around a winding track", makePark},
      {"car_park", "parked and moving cars, poles, reflectors, people and walls", makeCarPark},
      {"plain", "one trunk per 100 m^2, covered by parallel tracks", makePlain},
      {"loop", "a long way round that comes back to an avenue of look-alike trees", makeLoop},
      {"orchard", "trees in rows along alleys, fruit bins and pickers", makeOrchard},
      {"hills", "trees around a winding track over hills that tilt the laser", makeHills},
  };
  return kinds;
}

std::vector<std::string> worldNames() {
  std::vector<std::string> names;
  for (const WorldKind& kind : worldCatalog()) names.push_back(kind.name);
  return names;
}

World makeWorld(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator) {
  const auto& kinds = worldCatalog();
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const WorldKind& k) { return k.name == config.name; });
  if (kind == kinds.end()) {
    throw ConfigError({"simulation: there is no world '" + config.name + "'; did you mean '" +
                       nearestName(config.name, worldNames()) + "'?"});
  }
  World world = kind->make(config, vehicle, generator);
  refuseTooTight(world.route, vehicle, config.name);
  return world;
}

}  // namespace hymm::core
