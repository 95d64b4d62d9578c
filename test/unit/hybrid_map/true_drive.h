#pragma once

#include <functional>
#include <utility>
#include <variant>

#include "hybrid_map/hybrid_map.h"
#include "landmark_maps.h"
#include "simulation/simulation.h"

namespace hymm::core {

/// A drive through a simulated world with a map that is told the true landmarks.
class TrueDrive {
 public:
  TrueDrive(const SimulationConfig& simulation, const HybridMapConfig& config, std::uint64_t seed)
      : simulation_(simulation, simulatedCar(), seed), map_(config) {
    std::vector<Eigen::Vector2d> places;
    for (const TrueLandmark& landmark : simulation_.landmarks()) {
      places.push_back(landmark.position);
    }
    map_.apply(mapOf(places));
  }

  /// Calls `look(scan)` with each scan at its true pose, before it is written into the map.
  void drive(const std::function<void(const PosedScan&)>& look = {}) {
    while (auto simulated = simulation_.next()) {
      const auto* event = std::get_if<ScanEvent>(&simulated->event);
      if (event == nullptr) continue;
      PosedScan posed;
      posed.scan = event->scan;
      posed.T_map_laser = simulated->T_map_base * event->T_base_laser;
      posed.map_version = map_.landmarkVersion();
      if (look) look(posed);
      map_.insert(posed);
    }
  }

  HybridMap& map() { return map_; }
  const Simulation& simulation() const { return simulation_; }

 private:
  Simulation simulation_;
  HybridMap map_;
};

inline SimulationConfig worldOf(const std::string& name, int laps, double duration_s = 0.0) {
  SimulationConfig config;
  config.world.name = name;
  config.drive.laps = laps;
  config.drive.duration_s = duration_s;
  return config;
}

}  // namespace hymm::core
