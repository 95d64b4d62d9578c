#include "cekf/place_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cekf/relative_covariance.h"
#include "cekf/vehicle_state.h"

namespace hymm::core {
namespace {

// Of landmarks that are seen at once, among each other: of a confirmed landmark more than usual.
constexpr double kLandmarkDeviation_m = 0.1;
// Between two searches: one takes about 0.1 ms a landmark.
constexpr double kShortestPause_s = 1.0, kPausePerLandmark_s = 1e-3;
constexpr std::size_t kMostSeenLast = 12, kFewestSeenLast = 2;  // which fix a rigid motion
constexpr double kSeenLast_s = 10.0;
// For so long after a scan that was explained the next one is, whatever the motion's noise says
// when none is told: scan by scan the landmarks tell how the vehicle moves.
constexpr double kFollowed_s = 1.0;
// So little is known of a pose before the measurements.
constexpr double kUnknown_m = 100.0, kUnknown_rad = 1.0;

bool hasIdentities(const ObservationSet& set) {
  return std::any_of(set.observations.begin(), set.observations.end(),
                     [](const Observation& seen) { return seen.identity >= 0; });
}

bool mayTellPlace(const ObservationSet& set) {
  return set.observations.size() >= std::size_t{ConstellationPlace::kFewestPairs};
}

}  // namespace

bool PlaceFinder::isLost(const ObservationSet& set, const LandmarkRegistry& registry,
                         CompressedEkf& filter) {
  const double most = config_.linear_heading_rad * config_.linear_heading_rad;
  const auto isUncertain = [most](double variance) { return !(variance <= most); };
  const bool is_followed = !lost_since_s_ && set.time_s <= explained_s_ + kFollowed_s;
  bool is_lost =
      !is_followed && isUncertain(filter.vehicleCovariance()(2, 2)) && !hasIdentities(set);
  if (is_lost) {
    const std::vector<int> slots = seenLast(registry);
    for (const int slot : slots) filter.activate(slot);
    is_lost =
        slots.size() >= kFewestSeenLast && isUncertain(relativeCovariance(filter, slots)(2, 2));
  }
  if (!is_lost) {
    lost_since_s_.reset();
    next_search_s_ = -std::numeric_limits<double>::infinity();
  } else if (!lost_since_s_) {
    lost_since_s_ = set.time_s;
  }
  return is_lost;
}

/// At most twelve of those seen within some seconds of the last one: once a new part of the map has
/// begun, where the older ones lie does not matter.
std::vector<int> PlaceFinder::seenLast(const LandmarkRegistry& registry) {
  std::vector<std::pair<double, int>> all;  // the latest first
  all.reserve(registry.size());
  for (const RegisteredLandmark& landmark : registry.slots()) {
    if (landmark.id >= 0) all.emplace_back(-landmark.last_seen_s, landmark.slot);
  }
  const std::size_t count = std::min(all.size(), kMostSeenLast);
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  std::vector<int> slots;
  for (std::size_t k = 0; k < count; ++k) {
    if (all[k].first <= all.front().first + kSeenLast_s) slots.push_back(all[k].second);
  }
  return slots;
}

std::optional<ConstellationPlace> PlaceFinder::find(const ObservationSet& set,
                                                    const SensorPlacement& sensor,
                                                    const LandmarkRegistry& registry,
                                                    const CompressedEkf& filter) {
  if (set.time_s < next_search_s_ || !mayTellPlace(set)) return std::nullopt;
  SeenConstellation question;
  for (const Observation& seen : set.observations) {
    const LocatedLandmark located = locateLandmark(
        Pose2{}, sensor.T_base_sensor, seen.range_m - sensor.range_offset_m, seen.bearing_rad);
    const Eigen::Matrix2d covariance =
        located.G_measurement * seen.covariance * located.G_measurement.transpose();
    question.seen.push_back({located.position, 0.5 * covariance.trace(), seen.type});
  }
  std::vector<int> slots;
  for (const RegisteredLandmark& landmark : registry.all()) {
    if (landmark.observations < confirm_observations_ || landmark.identity >= 0) continue;
    question.landmarks.push_back({filter.landmark(landmark.slot),
                                  kLandmarkDeviation_m * kLandmarkDeviation_m, landmark.type});
    slots.push_back(landmark.slot);
  }
  const double pause_s = kPausePerLandmark_s * static_cast<double>(slots.size());
  next_search_s_ = set.time_s + std::max(kShortestPause_s, pause_s);
  question.expected = VehicleState::pose(filter);
  question.covariance = filter.vehicleCovariance().topLeftCorner<3, 3>();
  auto place = findConstellationPlace(question, config_.coincidence);
  if (!place) return std::nullopt;
  for (int& landmark : place->landmarks) {
    if (landmark != ConstellationPlace::kNone) landmark = slots[static_cast<std::size_t>(landmark)];
  }
  return place;
}

Eigen::Matrix3d PlaceFinder::priorCovariance() {
  return Eigen::Vector3d(kUnknown_m * kUnknown_m, kUnknown_m * kUnknown_m,
                         kUnknown_rad * kUnknown_rad)
      .asDiagonal();
}

}  // namespace hymm::core
