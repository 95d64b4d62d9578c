#include "relocaliser/place_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/angles.h"
#include "common/number_text.h"

namespace hymm::core {
namespace {

// A map that explains the last scans so much worse than the best, by the logarithm of the
// likelihood, is not looked in any more: what eight observations more make that are explained.
constexpr double kHopeless = 25.0;

// Of the time by whose scans maps are compared, what has to be over before one is given up.
constexpr double kMostOfRecent = 0.85;

Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, const Pose2& T) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T.rotation();
  return turn * covariance * turn.transpose();
}

double timeOfKept(const std::variant<MotionInput, ObservationSet>& kept) {
  struct Time {
    double operator()(const MotionInput& input) const { return timeOf(input); }
    double operator()(const ObservationSet& set) const { return set.time_s; }
  };
  return std::visit(Time{}, kept);
}

/// The motion from one time to another. Inputs before the first are in force at it.
template <class Kept>
MotionSince motionBetween(const Kept& kept, MotionSince motion, double from_s, double to_s) {
  bool begun = false;
  for (const auto& one : kept) {
    const auto* input = std::get_if<MotionInput>(&one);
    if (input == nullptr) continue;
    if (timeOf(*input) > to_s) break;
    if (!begun && timeOf(*input) > from_s) {
      motion.begin(from_s);
      begun = true;
    }
    motion.process(*input);
  }
  if (!begun) motion.begin(from_s);
  motion.advance(to_s);
  return motion;
}

}  // namespace

PlaceSearch::PlaceSearch(const RelocaliserConfig& config, const VehicleConfig& vehicle)
    : config_(config), vehicle_(vehicle) {}

void PlaceSearch::take(const MotionInput& input) {
  if (isFinite(input)) keep(input);
}

void PlaceSearch::take(const ObservationSet& set) {
  if (std::isfinite(set.time_s)) keep(set);
}

void PlaceSearch::keep(Kept kept) {
  const double newest_s = timeOfKept(kept);
  kept_.push_back(std::move(kept));
  while (timeOfKept(kept_.front()) < newest_s - config_.history_s) {
    kept_.pop_front();
    ++first_kept_;
  }
  if (!isOn() || next_ >= first_kept_) return;
  end();
  failure_ = "The search cannot keep up with what is observed: it is more than " +
             numberText(config_.history_s) +
             " s behind (history_s). Give it fewer particles, or a place to look around.";
}

bool PlaceSearch::begin(const SearchStart& start, std::string& problem) {
  end();
  problem = findGap(start.from_s);
  if (!problem.empty()) return false;
  calibration_ = start.calibration;
  beginAt(start.now_s, start.from_s);
  const MotionSince motion =
      motionBetween(kept_, MotionSince(vehicle_, calibration_), start.from_s, begun_s_);
  const std::optional<LocalMap> map =
      tryMakeLocalMap(movedOn(start.estimate, motion), config_.range_m, config_.local_map, problem);
  if (!map) return false;
  anywhere_ = false;
  addEngine();
  maps_.front().engine.begin(*map, begun_s_);
  return true;
}

bool PlaceSearch::beginAnywhere(const std::vector<LocalMap>& maps, const Calibration& calibration,
                                double now_s, std::string& problem) {
  end();
  if (kept_.empty()) {
    problem = "Nothing has been observed yet.";
    return false;
  }
  calibration_ = calibration;
  anywhere_ = true;
  beginAt(now_s, timeOfKept(kept_.front()));
  for (const LocalMap& map : maps) {
    addEngine();
    maps_.back().engine.beginGlobally(map, begun_s_);
  }
  return isOn();
}

void PlaceSearch::beginAt(double now_s, double earliest_s) {
  begun_s_ = std::max(earliest_s, now_s - config_.replay_s);
  restarted_s_ = begun_s_;
  next_ = first_kept_;
  for (std::size_t i = 0; i < kept_.size() && timeOfKept(kept_[i]) <= begun_s_; ++i) {
    const bool is_in_force = std::holds_alternative<MotionInput>(kept_[i]);
    if (is_in_force) next_ = first_kept_ + i;
  }
  turn_ = best_ = 0;
  unrivalled_.reset();
  scans_ = 0;
}

void PlaceSearch::addEngine() {
  const std::uint64_t seed = static_cast<std::uint64_t>(config_.seed) + engines_++;
  maps_.push_back({Relocaliser(config_, vehicle_, calibration_, RandomGenerator(seed)), {}});
  shares_.assign(maps_.size(), 1.0);
}

void PlaceSearch::end() {
  inquiry_.reset();
  maps_.clear();
  outcome_.reset();
  pose_.reset();
  failure_.clear();
}

void PlaceSearch::reset() {
  end();
  first_kept_ += kept_.size();
  kept_.clear();
}

std::size_t PlaceSearch::mapsLeft() const {
  return static_cast<std::size_t>(std::count_if(
      maps_.begin(), maps_.end(), [](const SearchedMap& map) { return !map.is_left; }));
}

PlaceSearch::Progress PlaceSearch::work(std::size_t rival_steps) {
  if (!isOn()) return Progress::kNothingWaits;
  const ObservationSet* set = nextSet();
  if (set == nullptr) return Progress::kNothingWaits;
  skipLeft();
  if (turn_ < maps_.size()) {
    if (!isLookedIn(maps_[turn_], *set, rival_steps)) return Progress::kPieceDone;
    ++turn_;
    skipLeft();
    if (turn_ < maps_.size()) return Progress::kPieceDone;
    weighMaps(set->time_s);
  }
  const std::optional<bool> has_rival_map = findRivalMap(rival_steps);
  if (!has_rival_map) return Progress::kPieceDone;
  finishScan(set->time_s, *has_rival_map);
  return Progress::kScanDone;
}

/// Whether the scan is done in the map. That another place in it may be a rival is a question of
/// several pieces.
bool PlaceSearch::isLookedIn(SearchedMap& map, const ObservationSet& set, std::size_t rival_steps) {
  if (!inquiry_) {
    map.outcome = map.engine.look(set);
    if (map.outcome && map.outcome->is_unsettled) {
      inquiry_.emplace(map.engine, map.outcome->T_map_base,
                       std::vector<const LocalMap*>{&map.engine.map()});
      return false;
    }
  } else {
    const std::optional<bool> has_rival = inquiry_->work(rival_steps);
    if (!has_rival) return false;
    inquiry_.reset();
    map.engine.settle(*map.outcome, *has_rival);
  }
  const bool has_place = map.outcome && !map.outcome->modes.empty();
  map.log_likelihood = has_place ? map.engine.logLikelihoodAt(map.outcome->modes.front().mean)
                                 : -std::numeric_limits<double>::infinity();
  return true;
}

/// Lets all maps have the motion up to the next set; null if none waits.
const ObservationSet* PlaceSearch::nextSet() {
  for (; next_ < first_kept_ + kept_.size(); ++next_) {
    const Kept& kept = kept_[next_ - first_kept_];
    if (const auto* input = std::get_if<MotionInput>(&kept)) {
      for (SearchedMap& map : maps_) map.engine.process(*input);
    } else if (timeOfKept(kept) > begun_s_) {
      return &std::get<ObservationSet>(kept);
    }
  }
  return nullptr;
}

void PlaceSearch::skipLeft() {
  while (turn_ < maps_.size() && maps_[turn_].is_left) ++turn_;
}

/// By how well each explains the last scans.
void PlaceSearch::weighMaps(double time_s) {
  double greatest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (maps_[i].is_left || maps_[i].log_likelihood <= greatest) continue;
    greatest = maps_[i].log_likelihood;
    best_ = i;
  }
  if (!std::isfinite(greatest)) return;
  if (scans_ == 0) told_from_s_ = time_s;
  ++scans_;
  const bool has_recent = scans_ >= static_cast<int>(RecentScans::kFewest) &&
                          time_s - told_from_s_ > kMostOfRecent * config_.recent_s;
  double sum = 0.0;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    SearchedMap& map = maps_[i];
    const double behind = greatest - map.log_likelihood;
    shares_[i] = map.is_left ? 0.0 : std::exp(-behind);
    sum += shares_[i];
    if (!has_recent || i == best_) continue;
    if (behind > kHopeless || isSamePlace(map)) map.is_left = true;
  }
  for (double& share : shares_) share /= sum;
}

/// Whether the map has found nothing but what the best one knows better.
bool PlaceSearch::isSamePlace(const SearchedMap& map) const {
  const auto& best = maps_[best_].outcome;
  return map.outcome && map.outcome->held_scans > 0 && best->held_scans > 0 &&
         !isElsewhere(inverse(best->T_map_base) * map.outcome->T_map_base);
}

bool PlaceSearch::isElsewhere(const Pose2& apart) const {
  return apart.position().norm() > config_.rival_distance_m ||
         std::abs(apart.yaw_rad) > config_.rival_angle_rad;
}

PosePrior PlaceSearch::spreadOfAll() const {
  PosePrior pose{outcome_->T_map_base, Eigen::Matrix3d::Zero()};
  double sum = 0.0;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (shares_[i] <= 0.0) continue;
    const Pose2& T_map_local = maps_[i].engine.map().T_map_local;
    for (const ParticleMode& mode : maps_[i].outcome->modes) {
      const double share = shares_[i] * mode.share;
      Eigen::Vector3d apart = (T_map_local * mode.mean).vector() - pose.mean.vector();
      apart.z() = wrapAngle(apart.z());
      pose.covariance += share * (turned(mode.covariance, T_map_local) + apart * apart.transpose());
      sum += share;
    }
  }
  pose.covariance /= sum;
  return pose;
}

/// Whether another map's heaviest mode is one: soon told, and most rivals are.
bool PlaceSearch::hasRivalMode() const {
  const double of_best = maps_[best_].log_likelihood;
  return std::any_of(maps_.begin(), maps_.end(), [&](const SearchedMap& map) {
    if (map.is_left || !std::isfinite(map.log_likelihood)) return false;
    const Pose2 apart = inverse(maps_[best_].outcome->T_map_base) * map.outcome->T_map_base;
    return isElsewhere(apart) && of_best - map.log_likelihood < config_.convergence.rival_margin;
  });
}

/// Whether another place in another map is a rival of the best one's; nothing: it is not known yet.
std::optional<bool> PlaceSearch::findRivalMap(std::size_t rival_steps) {
  const SearchedMap& best = maps_[best_];
  if (!best.outcome || !best.outcome->converged || unrivalled_ == best_) return false;
  if (!inquiry_) {
    if (hasRivalMode()) return true;
    inquiry_.emplace(best.engine, best.outcome->T_map_base, otherMaps());
    return std::nullopt;
  }
  const std::optional<bool> has_rival = inquiry_->work(rival_steps);
  if (has_rival) inquiry_.reset();
  return has_rival;
}

/// Than the best. Those that were left are asked, too: their particles may have missed the place.
std::vector<const LocalMap*> PlaceSearch::otherMaps() const {
  std::vector<const LocalMap*> others;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (i != best_) others.push_back(&maps_[i].engine.map());
  }
  return others;
}

/// With the best map's outcome, unless another one knows a place that explains the last scans, too.
void PlaceSearch::finishScan(double time_s, bool has_rival_map) {
  ++next_;
  turn_ = 0;
  time_s_ = time_s;
  outcome_ = maps_[best_].outcome;
  pose_.reset();
  if (outcome_ && !outcome_->modes.empty()) tellBest(has_rival_map);
  restartIfDue();
}

void PlaceSearch::tellBest(bool has_rival_map) {
  pose_ = spreadOfAll();
  outcome_->particles = 0;
  for (const SearchedMap& map : maps_) {
    if (!map.is_left && map.outcome) outcome_->particles += map.outcome->particles;
  }
  unrivalled_.reset();
  if (has_rival_map) {
    outcome_->converged = false;
    outcome_->doubt = "a place in another part of the map explains the last scans nearly as well";
  } else if (outcome_->converged) {
    unrivalled_ = best_;
  }
}

/// The vehicle may have driven from one map into another, or have seen too little at first.
void PlaceSearch::restartIfDue() {
  const bool is_found = outcome_ && outcome_->converged;
  if (!anywhere_ || is_found || time_s_ - restarted_s_ <= config_.neighbourhoods.restart_s) return;
  restarted_s_ = time_s_;
  scans_ = 0;
  for (SearchedMap& map : maps_) {
    map.is_left = false;
    map.engine.beginGlobally(LocalMap(map.engine.map()), time_s_);
  }
}

std::string PlaceSearch::findGap(double from_s) const {
  if (kept_.empty() || timeOfKept(kept_.back()) < from_s) {
    return "Nothing has been observed since the last scan in good order.";
  }
  const bool is_first_known = std::any_of(kept_.begin(), kept_.end(), [&](const Kept& kept) {
    return std::holds_alternative<MotionInput>(kept) && timeOfKept(kept) <= from_s;
  });
  if (is_first_known) return {};
  return "How the vehicle moved since the last scan in good order, " +
         numberText(timeOfKept(kept_.back()) - from_s) +
         " s ago, is not known: it is too long ago (history_s), or was before this node listened.";
}

std::vector<PlaceAtScan> PlaceSearch::wayFrom(double from_s) const {
  std::vector<PlaceAtScan> way;
  if (!outcome_) return way;
  MotionSince motion(vehicle_, calibration_);
  Pose2 T_first_now;
  for (const Kept& kept : kept_) {
    const double time_s = timeOfKept(kept);
    if (time_s > outcome_->time_s) break;
    if (const auto* input = std::get_if<MotionInput>(&kept)) {
      motion.process(*input);
    } else if (time_s > from_s) {
      if (!way.empty()) {
        motion.advance(time_s);
        T_first_now = T_first_now * motion.T_begin_end();
      }
      motion.begin(time_s);
      way.push_back({time_s, T_first_now});
    }
  }
  if (way.empty()) return way;
  const Pose2 T_map_first = outcome_->T_map_base * inverse(T_first_now);
  for (PlaceAtScan& pose : way) pose.T_map_base = T_map_first * pose.T_map_base;
  return way;
}

VehicleAmongLandmarks movedOn(VehicleAmongLandmarks estimate, const MotionSince& motion) {
  PosePrior& vehicle = estimate.vehicle;
  const Pose2& T = motion.T_begin_end();
  const Eigen::Matrix2d R = vehicle.mean.rotation();
  const Eigen::Vector2d way = R * T.position();
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity(), turn = J;
  J.topRightCorner<2, 1>() << -way.y(), way.x();
  turn.topLeftCorner<2, 2>() = R;
  vehicle.mean = vehicle.mean * T;
  vehicle.covariance =
      J * vehicle.covariance * J.transpose() + turn * motion.covariance() * turn.transpose();
  if (estimate.cross_covariance.size() > 0) {
    estimate.cross_covariance = (J * estimate.cross_covariance).eval();
  }
  return estimate;
}

}  // namespace hymm::core
