#include "perception/perception.h"

namespace hymm::core {

Perception::Perception(const PerceptionConfig& config) : config_(config) {}

std::vector<Observation> Perception::detect(const LaserScan&) const { return {}; }

}  // namespace hymm::core
