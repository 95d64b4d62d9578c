#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "simulation/simulation.h"

namespace hymm::core {

/// A short drive whose sensors are perfect.
inline SimulationConfig perfect(const std::string& world) {
  SimulationConfig config;
  config.world.name = world;
  config.drive.laps = 1;
  config.motion.noise_scale = 0.0;
  config.motion.draw_calibration = false;
  config.laser.range_deviation_m = 0.0;
  config.laser.range_deviation_relative = 0.0;
  config.laser.range_resolution_m = 0.0;
  config.laser.dark_range_m = 0.0;
  config.laser.missed_return_probability = 0.0;
  config.laser.spurious_return_probability = 0.0;
  return config;
}

inline SimulationConfig shortDrive(const std::string& world, double duration_s = 20.0) {
  SimulationConfig config;
  config.world.name = world;
  config.drive.duration_s = duration_s;
  return config;
}

inline std::vector<SimulatedEvent> all(Simulation& simulation) {
  std::vector<SimulatedEvent> events;
  while (auto event = simulation.next()) events.push_back(std::move(*event));
  return events;
}

inline std::vector<SimulatedEvent> all(const SimulationConfig& config, std::uint64_t seed = 1) {
  Simulation simulation(config, simulatedCar(), seed);
  return all(simulation);
}

}  // namespace hymm::core
