#include "perception/perception.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"

namespace hymm::core {
namespace {

/// `config` if it is usable; throws ConfigError if not.
PerceptionConfig checked(PerceptionConfig config) {
  std::vector<std::string> problems;
  ConfigSchema schema;
  config.describe(schema);
  for (const ConfigSchema::Entry& entry : schema.entries()) {
    const bool in_range = std::visit(
        [&](const auto* value) {
          using Value = std::decay_t<decltype(*value)>;
          if constexpr (std::is_same_v<Value, double> || std::is_same_v<Value, int>) {
            return std::isfinite(static_cast<double>(*value)) &&
                   entry.range.contains(static_cast<double>(*value));
          }
          return true;
        },
        entry.value);
    if (!in_range)
      problems.push_back("perception: " + entry.path + " must be " + entry.range.text() + ".");
  }
  if (config.trunks.min_diameter_m >= config.trunks.max_diameter_m) {
    problems.push_back("perception: trunks.min_diameter_m must be less than max_diameter_m.");
  }
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

bool sameObject(const Observation& trunk, const Observation& reflector) {
  const double apart_m =
      std::hypot(trunk.range_m - reflector.range_m,
                 trunk.range_m * wrapAngle(trunk.bearing_rad - reflector.bearing_rad));
  return apart_m < 0.5 * trunk.diameter_m + std::sqrt(trunk.diameter_variance);
}

void dropTrunksThatReflect(std::vector<Observation>& observations, std::size_t reflectors) {
  const auto first_trunk = observations.begin() + static_cast<std::ptrdiff_t>(reflectors);
  const auto reflects = [&](const Observation& trunk) {
    return std::any_of(observations.begin(), first_trunk,
                       [&](const Observation& reflector) { return sameObject(trunk, reflector); });
  };
  observations.erase(std::remove_if(first_trunk, observations.end(), reflects), observations.end());
}

}  // namespace

Perception::Perception(const PerceptionConfig& config)
    : config_(checked(config)),
      trunks_(config_.trunks, config_.laser),
      reflectors_(config_.reflectors, config_.laser) {}

std::vector<Observation> Perception::detect(const LaserScan& scan) const {
  const BeamView beams(scan);
  std::vector<Observation> observations;
  if (config_.reflectors.enabled) reflectors_.detect(beams, observations);
  const std::size_t reflectors = observations.size();
  if (config_.trunks.enabled) trunks_.detect(beams, observations);
  if (reflectors > 0) dropTrunksThatReflect(observations, reflectors);
  std::sort(
      observations.begin(), observations.end(),
      [](const Observation& a, const Observation& b) { return a.bearing_rad < b.bearing_rad; });
  return observations;
}

}  // namespace hymm::core
