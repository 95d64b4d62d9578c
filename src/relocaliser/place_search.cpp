#include "relocaliser/place_search.h"

#include <algorithm>
#include <cmath>

#include "common/number_text.h"
#include "relocaliser/whole_map.h"

namespace hymm::core {
namespace {

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
  if (!isFinite(input)) return;
  keep(input);
  if (engine_) engine_->process(input);
}

std::optional<RelocaliserOutcome> PlaceSearch::take(const ObservationSet& set) {
  if (!std::isfinite(set.time_s)) return std::nullopt;
  keep(set);
  if (!engine_) return std::nullopt;
  std::optional<RelocaliserOutcome> outcome = engine_->process(set);
  if (outcome) outcome_ = outcome;
  return outcome;
}

void PlaceSearch::keep(Kept kept) {
  const double newest_s = timeOfKept(kept);
  kept_.push_back(std::move(kept));
  while (timeOfKept(kept_.front()) < newest_s - config_.history_s) kept_.pop_front();
}

bool PlaceSearch::begin(const SearchStart& start, std::string& problem) {
  end();
  problem = findGap(start.from_s);
  if (!problem.empty()) return false;
  calibration_ = start.calibration;
  begun_s_ = std::max(start.from_s, timeOfKept(kept_.back()) - config_.replay_s);
  const MotionSince motion =
      motionBetween(kept_, MotionSince(vehicle_, calibration_), start.from_s, begun_s_);
  std::optional<LocalMap> map =
      tryMakeLocalMap(movedOn(start.estimate, motion), config_.range_m, config_.local_map, problem);
  if (!map) return false;
  this->start(std::move(*map), false);
  return true;
}

bool PlaceSearch::beginAnywhere(const std::vector<LandmarkEstimate>& landmarks,
                                const Calibration& calibration, std::string& problem) {
  end();
  std::optional<LocalMap> map = tryMakeWholeMap(landmarks, config_.whole_map, problem);
  if (!map) return false;
  if (kept_.empty()) {
    problem = "Nothing has been observed yet.";
    return false;
  }
  calibration_ = calibration;
  begun_s_ = std::max(timeOfKept(kept_.front()), timeOfKept(kept_.back()) - config_.replay_s);
  start(std::move(*map), true);
  return true;
}

void PlaceSearch::start(LocalMap map, bool anywhere) {
  engine_.emplace(config_, vehicle_, calibration_,
                  RandomGenerator(static_cast<std::uint64_t>(config_.seed) + searches_));
  ++searches_;
  if (anywhere) {
    engine_->beginGlobally(std::move(map), begun_s_);
  } else {
    engine_->begin(std::move(map), begun_s_);
  }
  for (const Kept& kept : kept_) {
    if (const auto* input = std::get_if<MotionInput>(&kept)) {
      engine_->process(*input);
    } else if (timeOfKept(kept) > begun_s_) {
      const auto outcome = engine_->process(std::get<ObservationSet>(kept));
      if (outcome) outcome_ = outcome;
    }
  }
}

void PlaceSearch::end() {
  engine_.reset();
  outcome_.reset();
}

void PlaceSearch::reset() {
  end();
  kept_.clear();
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
