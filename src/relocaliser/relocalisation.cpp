#include "relocaliser/relocalisation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/angles.h"

namespace hymm::core {
namespace {

// Deviations of a place found among all landmarks, around which it is looked for again: much more
// than the particles', whose map left out what errors landmarks have in common.
constexpr double kConfirmDeviation_m = 2.0;
constexpr double kConfirmDeviation_rad = 0.1;

// Landmarks that the filter is asked for; the map is made of the nearest of them.
constexpr std::size_t kMostAsked = 400;

double largestDeviation(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
}

/// The heaviest mode, with the spread of all around it, map frame.
PosePrior poseOf(const std::vector<ParticleMode>& modes, const Pose2& T_map_local) {
  const Pose2& best = modes.front().mean;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double share = 0.0;
  for (const ParticleMode& mode : modes) {
    Eigen::Vector3d apart = mode.mean.vector() - best.vector();
    apart.z() = wrapAngle(apart.z());
    spread += mode.share * (mode.covariance + apart * apart.transpose());
    share += mode.share;
  }
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_map_local.rotation();
  return {T_map_local * best, turn * spread * turn.transpose() / share};
}

}  // namespace

Relocalisation::Relocalisation(const RelocaliserConfig& config, const VehicleConfig& vehicle,
                               FilterLink& filter)
    : config_(config), filter_(filter), search_(config, vehicle) {
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::take(const MotionInput& input) { search_.take(input); }

const SearchReport& Relocalisation::take(const ObservationSet& observations,
                                         const PoseEstimate& pose) {
  poses_.push_back(pose);
  while (poses_.front().time_s < pose.time_s - config_.history_s) poses_.pop_front();
  report_.time_s = pose.time_s;
  report_.outcome.reset();
  report_.pose.reset();
  const bool was_on = search_.isOn();
  const std::optional<RelocaliserOutcome> outcome = search_.take(observations);
  if (!was_on) return report_;
  if (!outcome) {
    tell(SearchState::kSearching, "The scan tells too little to look for the place by.");
    return report_;
  }
  tellOutcome();
  if (!outcome->converged) return report_;
  if (report_.anywhere) {
    confirm();
  } else {
    resume();
  }
  return report_;
}

void Relocalisation::tellOutcome() {
  const RelocaliserOutcome& outcome = search_.outcome().value();
  report_.outcome = outcome;
  if (!outcome.modes.empty()) {
    report_.pose = poseOf(outcome.modes, search_.engine()->map().T_map_local);
  }
  tell(SearchState::kSearching, outcome.converged ? "The place is found." : outcome.doubt);
}

void Relocalisation::wish(const SearchWish& wish) {
  wish_ = wish;
  ++wishes_;
}

const SearchReport& Relocalisation::begin(const SearchOrder& order) {
  order_ = order;
  report_.order = order.number;
  report_.anywhere = false;
  search_.end();
  const std::string problem = filter_.suspend(order.from_s);
  if (!problem.empty()) {
    tell(SearchState::kFailed, problem);
    return report_;
  }
  const std::optional<SearchWish> wish = std::exchange(wish_, std::nullopt);
  is_elsewhere_ = wish.has_value();
  if (wish) {
    beginAround(*wish);
  } else {
    beginFromFilter();
  }
  return report_;
}

void Relocalisation::beginAround(const SearchWish& wish) {
  if (!wish.around) {
    beginAnywhere();
    return;
  }
  std::string problem;
  std::optional<FilterKnowledge> known = askNear(*wish.around, 0.0, problem);
  if (!known) {
    tell(SearchState::kFailed, problem);
    return;
  }
  known->estimate.vehicle = *wish.around;
  known->estimate.cross_covariance.resize(0, 0);  // the operator does not look at landmarks
  startSearch({order_.from_s, std::move(known->estimate), known->calibration});
}

void Relocalisation::beginFromFilter() {
  const auto then = std::find_if(poses_.begin(), poses_.end(), [&](const PoseEstimate& pose) {
    return pose.time_s >= order_.from_s;
  });
  if (then == poses_.end() || then->time_s > order_.from_s) {
    tell(SearchState::kFailed,
         "The filter's pose at the last scan in good order is not known: it is too long ago "
         "(history_s), or was before this node listened.");
    return;
  }
  const double way_m = (poses_.back().T_map_base.position() - then->T_map_base.position()).norm();
  std::string problem;
  std::optional<FilterKnowledge> known =
      askNear({then->T_map_base, then->covariance}, way_m, problem);
  if (!known) {
    tell(SearchState::kFailed, problem);
    return;
  }
  startSearch({order_.from_s, std::move(known->estimate), known->calibration});
}

void Relocalisation::beginAnywhere() {
  std::string problem;
  const std::vector<LandmarkEstimate> landmarks = filter_.landmarks();
  const std::optional<FilterKnowledge> known =
      landmarks.empty() ? std::nullopt : filter_.ask({landmarks.front().id}, problem);
  if (landmarks.empty()) problem = "The map has no landmarks to find a place by.";
  if (!known || !search_.beginAnywhere(landmarks, known->calibration, problem)) {
    tell(SearchState::kFailed, problem);
    return;
  }
  ++searches_;
  report_.anywhere = true;
  tell(SearchState::kSearching, "The search has begun, anywhere among the landmarks.");
}

std::optional<FilterKnowledge> Relocalisation::askNear(const PosePrior& place, double way_m,
                                                       std::string& problem) {
  const LocalMapConfig& map = config_.local_map;
  const double reach_m = config_.range_m + map.travel_m + way_m +
                         map.prior_deviations * largestDeviation(place.covariance);
  std::vector<std::pair<double, int>> near;
  for (const LandmarkEstimate& landmark : filter_.landmarks()) {
    const double distance_m = (landmark.position - place.mean.position()).norm();
    // What was found since is not in the map that the filter went back to.
    if (landmark.first_seen_s > order_.from_s) continue;
    if (distance_m <= reach_m) near.emplace_back(distance_m, landmark.id);
  }
  if (near.empty()) {
    problem = "There are no landmarks near the place where the vehicle is looked for.";
    return std::nullopt;
  }
  std::sort(near.begin(), near.end());
  if (near.size() > kMostAsked) near.resize(kMostAsked);
  std::vector<int> ids;
  for (const auto& [distance_m, id] : near) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return filter_.ask(ids, problem);
}

void Relocalisation::startSearch(const SearchStart& start) {
  std::string problem;
  if (!search_.begin(start, problem)) {
    tell(SearchState::kFailed, problem);
    return;
  }
  ++searches_;
  report_.anywhere = false;
  tell(SearchState::kSearching, "The search has begun.");
}

void Relocalisation::confirm() {
  const std::vector<PlaceAtScan> way = search_.wayFrom(search_.begun_s());
  PosePrior place{way.front().T_map_base, Eigen::Matrix3d::Zero()};
  place.covariance.diagonal() << kConfirmDeviation_m * kConfirmDeviation_m,
      kConfirmDeviation_m * kConfirmDeviation_m, kConfirmDeviation_rad * kConfirmDeviation_rad;
  const double way_m =
      (way.back().T_map_base.position() - way.front().T_map_base.position()).norm();
  std::string problem;
  std::optional<FilterKnowledge> known = askNear(place, way_m, problem);
  if (!known) {
    search_.end();
    tell(SearchState::kFailed, problem);
    return;
  }
  known->estimate.vehicle = place;
  known->estimate.cross_covariance.resize(0, 0);
  startSearch({way.front().time_s, std::move(known->estimate), known->calibration});
}

void Relocalisation::resume() {
  const FilterLink::ResumeAnswer answer =
      filter_.resume(order_.from_s, search_.wayFrom(order_.from_s), is_elsewhere_);
  search_.end();
  tell(answer.accepted ? SearchState::kAccepted : SearchState::kRefused, answer.sentence);
}

void Relocalisation::end() {
  search_.end();
  wish_.reset();
  report_.anywhere = false;
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::reset() {
  search_.reset();
  poses_.clear();
  wish_.reset();
  report_ = {};
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::tell(SearchState state, std::string reason) {
  report_.state = state;
  report_.reason = std::move(reason);
}

}  // namespace hymm::core
