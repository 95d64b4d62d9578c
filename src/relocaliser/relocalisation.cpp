#include "relocaliser/relocalisation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hymm::core {
namespace {

// Landmarks that the filter is asked for; the map is made of the nearest of them.
constexpr std::size_t kMostAsked = 400;

double largestDeviation(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
}

}  // namespace

Relocalisation::Relocalisation(const RelocaliserConfig& config, const VehicleConfig& vehicle,
                               FilterLink& filter)
    : config_(config), filter_(filter), search_(config, vehicle) {
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::take(const MotionInput& input) { search_.take(input); }

void Relocalisation::take(const ObservationSet& observations, const PoseEstimate& pose) {
  poses_.push_back(pose);
  while (poses_.front().time_s < pose.time_s - config_.history_s) poses_.pop_front();
  search_.take(observations);
  if (!search_.failure().empty()) tell(SearchState::kFailed, search_.failure());
  if (search_.isOn() || !middles_.empty()) return;
  report_.outcome.reset();
  report_.pose.reset();
  report_.time_s = pose.time_s;
  is_news_ = true;
}

bool Relocalisation::work() {
  if (!middles_.empty()) {
    makeNextMap();
    return true;
  }
  const PlaceSearch::Progress progress = search_.work();
  if (progress == PlaceSearch::Progress::kScanDone) tellScan();
  return progress != PlaceSearch::Progress::kNothingWaits;
}

void Relocalisation::tellScan() {
  report_.time_s = search_.time_s();
  report_.outcome = search_.outcome();
  report_.pose = search_.pose();
  if (!report_.outcome) {
    tell(SearchState::kSearching, "The scan tells too little to look for the place by.");
  } else if (report_.outcome->converged && report_.time_s > order_.from_s) {
    resume();
  } else if (report_.outcome->converged) {
    tell(SearchState::kSearching, "The place is found, and the filter goes on at the next scan.");
  } else {
    tell(SearchState::kSearching, report_.outcome->doubt);
  }
}

void Relocalisation::begin(const SearchOrder& order) {
  stop();
  const bool is_retry = order_.number > 0 && order.from_s == order_.from_s;
  order_ = order;
  // The clock of one who orders by hand may be another than that of the recording.
  if (!poses_.empty()) order_.given_s = std::min(order_.given_s, poses_.back().time_s);
  order_.given_s = std::max(order_.given_s, order_.from_s);
  report_.order = order.number;
  const std::string problem = filter_.suspend(order.from_s);
  if (!problem.empty()) {
    tell(SearchState::kFailed, problem);
    return;
  }
  const std::optional<SearchWish> wish = std::exchange(wish_, std::nullopt);
  is_elsewhere_ = wish || is_retry;
  if (wish) {
    beginAround(*wish);
  } else if (is_retry) {  // it is not where the filter would have it
    beginAnywhere();
  } else {
    beginFromFilter();
  }
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
  startSearch({order_.from_s, order_.given_s, std::move(known->estimate), known->calibration});
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
  // Those that came after the order are left aside: how many depends on the machine.
  const auto now = std::find_if(poses_.rbegin(), poses_.rend(), [&](const PoseEstimate& pose) {
    return pose.time_s <= order_.given_s;
  });
  const double way_m = (now->T_map_base.position() - then->T_map_base.position()).norm();
  std::string problem;
  std::optional<FilterKnowledge> known =
      askNear({then->T_map_base, then->covariance}, way_m, problem);
  if (!known) {
    tell(SearchState::kFailed, problem);
    return;
  }
  startSearch({order_.from_s, order_.given_s, std::move(known->estimate), known->calibration});
}

void Relocalisation::beginAnywhere() {
  report_.anywhere = true;
  landmarks_.clear();
  for (const LandmarkEstimate& landmark : filter_.landmarks()) {
    if (landmark.first_seen_s <= order_.from_s) landmarks_.push_back(landmark);
  }
  middles_ = findMiddles(landmarks_, config_.neighbourhoods.spacing_m);
  const auto most = static_cast<std::size_t>(config_.neighbourhoods.most);
  if (middles_.empty()) {
    tell(SearchState::kFailed, "The map has no landmarks to find a place by.");
  } else if (middles_.size() > most) {
    const std::string needed = std::to_string(middles_.size());
    middles_.clear();
    tell(SearchState::kFailed, "To look anywhere in this map takes " + needed +
                                   " local maps, more than " + std::to_string(most) +
                                   " (neighbourhoods/most). Say roughly where the vehicle is "
                                   "(initialpose).");
  } else {
    tell(SearchState::kSearching, "Local maps are made of all landmarks.");
  }
}

void Relocalisation::makeNextMap() {
  const Eigen::Vector2d middle = middles_.back();
  middles_.pop_back();
  std::string problem;
  const std::optional<FilterKnowledge> known =
      filter_.ask(landmarksAround(middle, landmarks_, config_.local_map), problem);
  if (!known) {
    stop();
    tell(SearchState::kFailed, problem);
    return;
  }
  calibration_ = known->calibration;
  std::optional<LocalMap> map =
      tryMakeNeighbourhood(known->estimate.landmarks, middle, config_.neighbourhoods.spacing_m,
                           config_.local_map, problem);
  if (map) maps_.push_back(std::move(*map));
  if (middles_.empty()) searchInMaps();
}

void Relocalisation::searchInMaps() {
  std::string problem = "Nowhere do two landmarks know each other well enough to find a place by.";
  const std::vector<LocalMap> maps = std::exchange(maps_, {});
  if (maps.empty() || !search_.beginAnywhere(maps, calibration_, order_.given_s, problem)) {
    tell(SearchState::kFailed, problem);
    return;
  }
  ++searches_;
  tell(SearchState::kSearching, "The search has begun, anywhere among the landmarks, in " +
                                    std::to_string(maps.size()) + " local maps.");
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
  tell(SearchState::kSearching, "The search has begun.");
}

void Relocalisation::resume() {
  const FilterLink::ResumeAnswer answer =
      filter_.resume(order_.from_s, search_.wayFrom(order_.from_s), is_elsewhere_);
  search_.end();
  tell(answer.accepted ? SearchState::kAccepted : SearchState::kRefused, answer.sentence);
}

void Relocalisation::stop() {
  search_.end();
  middles_.clear();
  maps_.clear();
  report_.anywhere = false;
}

void Relocalisation::end() {
  stop();
  wish_.reset();
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::reset() {
  stop();
  search_.reset();
  poses_.clear();
  wish_.reset();
  order_ = {};
  report_ = {};
  tell(SearchState::kIdle, "No search is on.");
}

void Relocalisation::tell(SearchState state, std::string reason) {
  report_.state = state;
  report_.reason = std::move(reason);
  is_news_ = true;
}

}  // namespace hymm::core
