#include "information_map/full_evaluation.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/error.h"

namespace hymm::core {

FullEvaluation evaluateFully(const InformationMapConfig& config, const LandmarkField& field,
                             const InformationEvaluator::Occlusion& hides) {
  std::vector<std::string> problems = config.problems();
  if (!problems.empty()) throw ConfigError(problems);
  const std::vector<double> values = config.level_sets.valuesAscending(problems);
  FullEvaluation full{{config.level_sets.resolution_m, static_cast<int>(values.size())}, 0};
  if (field.size() == 0) return full;

  InformationEvaluator evaluator(config.information, hides);
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(config.information.sensor.range_m);
  const Cell low = full.lattice.cellAt(field.low() - reach);
  const Cell high = full.lattice.cellAt(field.high() + reach);
  for (std::int32_t y = low.y; y <= high.y; ++y) {
    for (std::int32_t x = low.x; x <= high.x; ++x) {
      const double information = evaluator.at(field, full.lattice.centre({x, y})).value;
      const auto reached = std::upper_bound(values.begin(), values.end(), information);
      full.lattice.set({x, y}, static_cast<int>(reached - values.begin()));
    }
  }
  full.evaluations = evaluator.counts().evaluations;
  return full;
}

}  // namespace hymm::core
