#pragma once

#include <string>
#include <vector>

#include "common/random.h"
#include "simulation/simulation_config.h"
#include "simulation/world.h"

namespace hymm::core {

/// A kind of world. To add one, write a function that makes it and name it in the catalogue.
struct WorldKind {
  std::string name;
  std::string description;  ///< one line for people
  World (*make)(const WorldConfig&, const VehicleConfig&, RandomGenerator&);
};

const std::vector<WorldKind>& worldCatalog();

/// Names of the worlds, for instance for a list of choices.
std::vector<std::string> worldNames();

/// Makes the world that the configuration names. Throws ConfigError if there is none, if it cannot
/// hold what is asked for, or if the vehicle cannot drive there.
World makeWorld(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator);

/// Trees of 0.1 to 1 m, bushes, shelters and people around a winding track.
World makePark(const WorldConfig& config, const VehicleConfig& vehicle, RandomGenerator& generator);

/// Rows of parked cars, poles, reflectors, moving cars and walls.
World makeCarPark(const WorldConfig& config, const VehicleConfig& vehicle,
                  RandomGenerator& generator);

/// One trunk per 100 m^2 on a square, covered by parallel tracks.
World makePlain(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator);

/// Trees in rows along alleys, fruit bins and pickers.
World makeOrchard(const WorldConfig& config, const VehicleConfig& vehicle,
                  RandomGenerator& generator);

/// Trees around a winding track over hills and hollows.
World makeHills(const WorldConfig& config, const VehicleConfig& vehicle,
                RandomGenerator& generator);

/// A long way round that comes back to an avenue of look-alike trees.
World makeLoop(const WorldConfig& config, const VehicleConfig& vehicle, RandomGenerator& generator);

}  // namespace hymm::core
