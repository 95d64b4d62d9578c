#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cekf/cekf_slam.h"
#include "simulation/simulation.h"

namespace hymm::test {

/// The landmark map as it changes while a filter drives: one version every `period_s` in which
/// landmarks are known.
class MapHistory {
 public:
  using Source = std::function<std::optional<core::SensorEvent>()>;

  struct Version {
    core::LandmarkMap map;
    core::PoseEstimate pose;
  };

  MapHistory(Source source, const core::CekfSlamConfig& config, const core::VehicleConfig& vehicle,
             double period_s, double block_range_m)
      : source_(std::move(source)),
        slam_(config, vehicle),
        period_s_(period_s),
        block_range_m_(block_range_m) {}

  /// The next version; nothing when the drive is over.
  std::optional<Version> next() {
    while (const auto event = source_()) {
      const auto outcome = slam_.process(*event);
      if (!outcome || !outcome->accepted || slam_.landmarkCount() == 0) continue;
      if (outcome->pose.time_s < next_s_) continue;
      next_s_ = outcome->pose.time_s + period_s_;
      return Version{slam_.landmarkMap(block_range_m_), outcome->pose};
    }
    return std::nullopt;
  }

 private:
  Source source_;
  core::CekfSlam slam_;
  double period_s_, block_range_m_;
  double next_s_ = 0.0;
};

/// A drive through a simulated world whose landmarks are detected by the sensor itself.
inline MapHistory simulatedHistory(const std::string& world, int laps, unsigned seed,
                                   double block_range_m = 30.0, double period_s = 1.0) {
  core::SimulationConfig config;
  config.world.name = world;
  config.drive.laps = laps;
  config.laser.enabled = false;
  config.gps.enabled = false;
  config.detections.enabled = true;
  const core::VehicleConfig vehicle = core::simulatedCar();
  auto simulation = std::make_shared<core::Simulation>(config, vehicle, seed);
  core::CekfSlamConfig filter;
  filter.observation_input = "detections";
  const auto source = [simulation]() -> std::optional<core::SensorEvent> {
    auto simulated = simulation->next();
    if (!simulated) return std::nullopt;
    return std::move(simulated->event);
  };
  return MapHistory(source, filter, vehicle, period_s, block_range_m);
}

}  // namespace hymm::test
