#pragma once

#include <cstddef>

#include "information_map/information_evaluator.h"
#include "information_map/information_map_config.h"
#include "information_map/landmark_field.h"
#include "information_map/level_lattice.h"

namespace hymm::core {

/// Level sets by evaluating every cell in the box around all landmarks and what is in range of
/// them: what LevelSetSearch is compared with.
struct FullEvaluation {
  LevelLattice lattice;
  std::size_t evaluations = 0;
};

/// Throws ConfigError if the configuration is unusable.
FullEvaluation evaluateFully(const InformationMapConfig& config, const LandmarkField& field,
                             const InformationEvaluator::Occlusion& hides = nullptr);

}  // namespace hymm::core
