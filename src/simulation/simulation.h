#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/sensor_event.h"
#include "simulation/simulation_config.h"
#include "simulation/terrain.h"
#include "simulation/truth.h"
#include "vehicle/motion_model.h"

namespace hymm::core {

/// One sensor event and what was true when it happened.
struct SimulatedEvent {
  SensorEvent event;
  Pose2 T_map_base;
  /// Of a scan: the landmark that each beam truly met first, or -1. Empty for other events.
  std::vector<int> beam_landmarks;
  /// Of a scan, where the world has hills: the height of the ground under base_link, as an
  /// altimeter measures it, m.
  std::optional<double> height_m;
};

/// A vehicle with its sensors driving through a world: an ordered stream of sensor events, with
/// truth. A pure function of configuration, vehicle and seed. The map frame stands at the first
/// pose of base_link with heading 0, as hymm's does; time begins at kStartTime_s, at rest.
///
///   Simulation simulation(config, vehicle, seed);
///   while (auto simulated = simulation.next()) filter.process(simulated->event);
class Simulation {
 public:
  static constexpr double kStartTime_s = 1.0;

  /// Throws ConfigError for a configuration or vehicle that cannot be simulated.
  Simulation(const SimulationConfig& config, const VehicleConfig& vehicle, std::uint64_t seed);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// The next event, ordered by time (of equal times motion comes first); nothing at the end. Scans
  /// of a rotating laser come when they are complete, with the stamp of their first beam: a
  /// SensorMerger brings them into the order that filters need.
  std::optional<SimulatedEvent> next();

  /// Share of the drive that is done, 0 to 1.
  double progress() const;

  /// All landmarks of the world, by id, which counts from 0.
  const std::vector<TrueLandmark>& landmarks() const;

  TrueOccupancy occupancy(double resolution_m) const;

  /// In map; heights count from its origin.
  const Terrain& terrain() const;

  /// What really maps the encoders' readings to speed and steering (or yaw rate).
  const Calibration& calibration() const;

  /// Places map in the local east-north frame of the GPS fixes.
  const Pose2& T_enu_map() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace hymm::core
