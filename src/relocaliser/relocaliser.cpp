#include "relocaliser/relocaliser.h"

#include <algorithm>
#include <cmath>

#include "relocaliser/rival_search.h"
#include "relocaliser/visible_landmarks.h"

namespace hymm::core {
namespace {

// Modes that hold less weight than this are not told.
constexpr double kLeastShare = 1e-4;

Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double yaw_rad) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Pose2{0.0, 0.0, yaw_rad}.rotation();
  return turn * covariance * turn.transpose();
}

}  // namespace

Relocaliser::Relocaliser(const RelocaliserConfig& config, const VehicleConfig& vehicle,
                         const Calibration& calibration, RandomGenerator generator)
    : config_(config),
      generator_(generator),
      filter_(config.particles),
      motion_(vehicle, calibration),
      recent_(config.recent_s),
      held_(config.convergence.holdSpacing_s()) {}

void Relocaliser::beginGlobally(LocalMap map, double time_s) {
  map_ = std::move(map);
  prior_.reset();
  recent_.clear();
  motion_.begin(time_s);
  begun_ = true;
  started_ = false;
  time_s_.reset();
  held_.clear();
  is_unrivalled_ = false;
  ++counts_.begun;
}

void Relocaliser::begin(LocalMap map, double time_s) {
  beginGlobally(std::move(map), time_s);
  prior_ = map_.vehicle;
  prior_->covariance *= config_.prior_inflation;
}

bool Relocaliser::process(const MotionInput& input) {
  const bool taken = motion_.process(input);
  if (!taken) ++counts_.refused_motion;
  return taken;
}

std::optional<RelocaliserOutcome> Relocaliser::process(const ObservationSet& set) {
  std::optional<RelocaliserOutcome> outcome = look(set);
  if (outcome && outcome->is_unsettled) {
    const RivalAnswer answer = findRival(rivalQuestion(map_, outcome->T_map_base));
    settle(*outcome, answer.kind != RivalAnswer::Kind::kNoRival);
  }
  return outcome;
}

std::optional<RelocaliserOutcome> Relocaliser::look(const ObservationSet& set) {
  if (!begun_) return std::nullopt;
  const std::vector<ObservedPoint> points = observedPoints(set, config_.density.min_deviation_m);
  if (!std::isfinite(set.time_s) || (time_s_ && set.time_s <= *time_s_)) {
    ++counts_.refused_scans;
    return std::nullopt;
  }
  ++counts_.scans;
  time_s_ = set.time_s;
  motion_.advance(set.time_s);
  if (prior_) prior_ = moved(*prior_, motion_.T_begin_end(), motion_.covariance());
  bound_.move(motion_.T_begin_end(), motion_.covariance());
  recent_.move(motion_.T_begin_end(), motion_.covariance());
  recent_.add(set.time_s, points);
  bool resampled = false;
  if (started_) {
    filter_.move(motion_.step(), generator_);
    filter_.weigh(DensityMap(visibleLandmarks(points), points, viewArea_m2(), config_.density));
  } else if (static_cast<int>(points.size()) < config_.initial_observations) {
    ++counts_.poor_scans;
    motion_.begin(set.time_s);
    return std::nullopt;
  } else {
    start(points);
  }
  RelocaliserOutcome outcome = judge(points, set.T_base_sensor);
  resampled = filter_.resampleIfDue(generator_);
  outcome.resampled = resampled;
  outcome.time_s = set.time_s;
  motion_.begin(set.time_s);
  return outcome;
}

double Relocaliser::logLikelihoodAt(const Pose2& place) const {
  return core::logLikelihoodAt(place, map_.landmarks, recent_.points(), viewArea_m2(),
                               config_.density);
}

void Relocaliser::start(const std::vector<ObservedPoint>& points) {
  const DensityMap density(map_.landmarks, points, viewArea_m2(), config_.density);
  const HelicalRegions regions = regionsOf(points);
  const int count = isGlobal() ? config_.global_particles : config_.initial_particles;
  filter_.begin(
      sampleHelicalRegions(regions, density, static_cast<std::size_t>(count), generator_));
  started_ = filter_.particles().size() > 0;
  if (prior_) {
    bound_.begin(*prior_);
  } else {
    bound_.beginAnywhere();
  }
}

HelicalRegions Relocaliser::regionsOf(const std::vector<ObservedPoint>& points) const {
  HelicalRegions regions{map_.landmarks, points, {}, prior_, config_.local_map.prior_deviations};
  if (prior_) {
    regions.headings = {prior_->mean.yaw_rad,
                        config_.local_map.prior_deviations * std::sqrt(prior_->covariance(2, 2))};
  }
  return regions;
}

std::vector<LocalLandmark> Relocaliser::visibleLandmarks(
    const std::vector<ObservedPoint>& points) const {
  return findVisibleLandmarks(filter_.particles(), points, map_.landmarks);
}

double Relocaliser::viewArea_m2() const {
  return 0.5 * config_.field_of_view_rad * config_.range_m * config_.range_m;
}

RelocaliserOutcome Relocaliser::judge(const std::vector<ObservedPoint>& points,
                                      const Pose2& T_base_sensor) {
  RelocaliserOutcome outcome;
  outcome.particles = filter_.particles().size();
  outcome.effective_number = filter_.effectiveNumber();
  outcome.modes = computeModes(filter_.particles(), config_.particles.bin(), kLeastShare);
  Eigen::Vector3d limit = Eigen::Vector3d::Zero();
  if (!outcome.modes.empty()) {
    ParticleMode& best = outcome.modes.front();
    outcome.T_map_base = map_.T_map_local * best.mean;
    const SensorView view{T_base_sensor, config_.expected_range_m, config_.field_of_view_rad};
    outcome.explanation = explainScan(best.mean, best.covariance, points, map_.landmarks, view,
                                      config_.convergence.gate_probability);
    limit = convergedDeviations(best.mean, motion_.deviationOfOneSecond(),
                                outcome.explanation.information, config_.convergence);
    bound_.observe(best.mean, outcome.explanation);
    best.covariance = raisedTo(best.covariance, bound_.covariance());
    outcome.covariance = turned(best.covariance, map_.T_map_local.yaw_rad);
  }
  outcome.doubt = findDoubt(outcome.modes, outcome.explanation, limit, config_.convergence);
  if (outcome.doubt.empty()) {
    held_.add(*time_s_, outcome.explanation, motion_.T_begin_end().position().norm());
    outcome.doubt = findDoubt(held_, config_.convergence);
    outcome.is_unsettled = outcome.doubt.empty() && !is_unrivalled_;
  } else {
    held_.clear();
    is_unrivalled_ = false;
  }
  outcome.held_scans = held_.scans();
  outcome.converged = outcome.doubt.empty() && !outcome.is_unsettled;
  return outcome;
}

void Relocaliser::settle(RelocaliserOutcome& outcome, bool has_rival) {
  is_unrivalled_ = !has_rival;
  outcome.is_unsettled = false;
  outcome.converged = is_unrivalled_;
  if (is_unrivalled_) return;
  ++counts_.rivals;
  outcome.doubt = "another place explains the last scans nearly as well";
}

RivalQuestion Relocaliser::rivalQuestion(const LocalMap& map, const Pose2& T_map_believed) const {
  const double of_believed = logLikelihoodAt(inverse(map_.T_map_local) * T_map_believed);
  return {map.landmarks,
          recent_.points(),
          viewArea_m2(),
          config_.density,
          prior_,
          config_.local_map.prior_deviations,
          inverse(map.T_map_local) * T_map_believed,
          config_.rival_distance_m,
          config_.rival_angle_rad,
          of_believed - config_.convergence.rival_margin,
          static_cast<std::size_t>(config_.rival_bounds)};
}

}  // namespace hymm::core
