#include "pipeline/observation_log.h"

#include <cmath>

#include "common/number_text.h"

namespace hymm::core {
namespace {

constexpr std::size_t kMostWaitingBytes = 1 << 20;

}  // namespace

ObservationLog::ObservationLog(const std::filesystem::path& folder)
    : lines_(folder / "observations.csv") {
  lines_.add("t,landmark,range,bearing,range_deviation,bearing_deviation,diameter");
}

void ObservationLog::add(const ScanOutcome& outcome) {
  for (std::size_t i = 0; i < outcome.associations.size(); ++i) {
    const Observation& observation = outcome.observations.observations[i];
    std::string line = numberText(outcome.pose.time_s);
    line += ',' + std::to_string(outcome.associations[i].landmark_id);
    for (const double value :
         {observation.range_m, observation.bearing_rad, std::sqrt(observation.covariance(0, 0)),
          std::sqrt(observation.covariance(1, 1)), observation.diameter_m}) {
      line += ',' + numberText(value);
    }
    lines_.add(line);
  }
  if (lines_.waiting() > kMostWaitingBytes) lines_.flush();
}

}  // namespace hymm::core
