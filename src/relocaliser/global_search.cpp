#include "relocaliser/global_search.h"

#include <stdexcept>
#include <utility>

namespace hymm::core {

GlobalSearch::GlobalSearch(const RelocaliserConfig& config, const VehicleConfig& vehicle,
                           const Calibration& calibration, std::vector<LocalMap> maps,
                           double restart_s, RandomGenerator generator)
    : maps_(std::move(maps)), restart_s_(restart_s), same_place_m_(config.rival_distance_m) {
  if (maps_.empty()) throw std::invalid_argument("GlobalSearch needs a map to search in");
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    searches_.emplace_back(config, vehicle, calibration, RandomGenerator(generator()));
  }
}

void GlobalSearch::begin(double time_s) {
  begun_s_ = time_s;
  for (std::size_t i = 0; i < maps_.size(); ++i) searches_[i].beginGlobally(maps_[i], time_s);
}

void GlobalSearch::process(const MotionInput& input) {
  for (Relocaliser& search : searches_) search.process(input);
}

std::optional<RelocaliserOutcome> GlobalSearch::process(const ObservationSet& set) {
  std::optional<RelocaliserOutcome> found;
  bool contradicted = false;
  for (Relocaliser& search : searches_) {
    const auto outcome = search.process(set);
    if (!outcome || !outcome->converged) continue;
    if (found &&
        (found->T_map_base.position() - outcome->T_map_base.position()).norm() > same_place_m_) {
      contradicted = true;
    }
    if (!found || outcome->explanation.explained > found->explanation.explained) found = outcome;
  }
  if (contradicted) ++contradictions_;
  if (found && !contradicted) return found;
  if (set.time_s - begun_s_ > restart_s_) begin(set.time_s);
  return std::nullopt;
}

}  // namespace hymm::core
