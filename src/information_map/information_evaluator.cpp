#include "information_map/information_evaluator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "common/error.h"

namespace hymm::core {
namespace {

// From this field of view on, no landmark is taken for cut by its edges.
constexpr double kAllAround_rad = 6.28;

// Directions that take turns where there are too many landmarks: position and heading are told best
// by landmarks all around.
constexpr int kSectors = 12;

// Times as many landmarks, at most, where the heading that sees a part of them is yet to be found.
constexpr double kMostViews = 4.0;

}  // namespace

InformationEvaluator::InformationEvaluator(const InformationConfig& config, Occlusion hides)
    : config_(config), hides_(std::move(hides)), measure_(config.measure, config.length_m) {
  if (config.heading == "omnidirectional") {
    heading_ = Heading::kOmnidirectional;
  } else if (config.heading == "worst") {
    heading_ = Heading::kWorst;
  } else if (config.heading == "best") {
    heading_ = Heading::kBest;
  } else if (config.heading == "fixed") {
    heading_ = Heading::kFixed;
  } else {
    throw ConfigError({"heading: '" + config.heading +
                       "' is not known; choose omnidirectional, worst, best or fixed."});
  }
  // A sensor that looks all around is the same at every heading.
  if (config.sensor.field_of_view_rad >= kAllAround_rad) heading_ = Heading::kOmnidirectional;
}

AchievableInformation InformationEvaluator::at(const LandmarkField& field,
                                               const Eigen::Vector2d& place) {
  ++counts_.evaluations;
  const double margin_m = gather(field, place);
  const bool is_extreme = heading_ == Heading::kWorst || heading_ == Heading::kBest;
  if (heading_ == Heading::kFixed) keepInField(config_.fixed_heading_rad);
  const double views =
      is_extreme ? std::min(kMostViews, 2.0 * kPi / config_.sensor.field_of_view_rad) : 1.0;
  keepMost(static_cast<std::size_t>(views * static_cast<double>(kMostLandmarks)));
  assembleCovariance(field);
  AchievableInformation information;
  switch (heading_) {
    case Heading::kOmnidirectional:
      subset_.resize(visible_.size());
      for (std::size_t i = 0; i < subset_.size(); ++i) subset_[i] = static_cast<int>(i);
      information = ofSubset();
      break;
    case Heading::kFixed:
      information = ofHeading(config_.fixed_heading_rad);
      break;
    case Heading::kWorst:
      information = ofExtremeHeading(false);
      break;
    case Heading::kBest:
      information = ofExtremeHeading(true);
      break;
  }
  const bool distances_decide = heading_ == Heading::kOmnidirectional && !hides_;
  information.margin_m = distances_decide ? margin_m : 0.0;
  return information;
}

AchievableInformation InformationEvaluator::at(const LandmarkField& field,
                                               const Pose2& T_map_sensor) {
  ++counts_.evaluations;
  gather(field, T_map_sensor.position());
  keepInField(T_map_sensor.yaw_rad);
  keepMost(kMostLandmarks);
  assembleCovariance(field);
  return ofHeading(T_map_sensor.yaw_rad);
}

/// Landmarks within range for certain, nearest first; returns the margin.
double InformationEvaluator::gather(const LandmarkField& field, const Eigen::Vector2d& place) {
  const ExpectedSensor& sensor = config_.sensor;
  double margin_m = AchievableInformation::kLargestMargin_m;
  visible_.clear();
  field.visitNear(place, sensor.range_m + margin_m, [&](int index) {
    Visible candidate;
    candidate.index = index;
    candidate.offset = field.position(index) - place;
    candidate.view = viewRegion(candidate.offset, field.covariance(index), sensor.region_sigmas);
    const double inside_m = rangeMargin_m(candidate.view, sensor);
    margin_m = std::min(margin_m, std::abs(inside_m));
    if (inside_m < 0.0 || (hides_ && hides_(place, field.position(index)))) return;
    visible_.push_back(candidate);
  });
  std::sort(visible_.begin(), visible_.end(), [](const Visible& a, const Visible& b) {
    const double to_a = a.offset.squaredNorm(), to_b = b.offset.squaredNorm();
    return to_a != to_b ? to_a < to_b : a.index < b.index;
  });
  return margin_m;
}

void InformationEvaluator::keepInField(double heading_rad) {
  visible_.erase(
      std::remove_if(visible_.begin(), visible_.end(),
                     [&](const Visible& visible) { return !isInField(visible.view, heading_rad); }),
      visible_.end());
}

/// The nearest of each direction, then the second of each, and so on; still nearest first.
/// Directions count from the nearest landmark, so that they turn with the map.
void InformationEvaluator::keepMost(std::size_t most) {
  if (visible_.size() <= most) return;
  std::array<int, kSectors> taken{};
  turns_.clear();
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    const double turn = wrapAngle(visible_[i].view.bearing_rad - visible_[0].view.bearing_rad);
    const auto sector = static_cast<int>(std::lround(turn / (2.0 * kPi) * kSectors));
    turns_.emplace_back(taken[std::size_t((sector + kSectors) % kSectors)]++, i);
  }
  std::sort(turns_.begin(), turns_.end());
  turns_.resize(most);
  std::sort(turns_.begin(), turns_.end(),
            [](const auto& a, const auto& b) { return a.second < b.second; });
  for (std::size_t k = 0; k < most; ++k) visible_[k] = visible_[turns_[k].second];
  visible_.resize(most);
}

/// P_L (32) of all visible landmarks, and which of its blocks are told.
void InformationEvaluator::assembleCovariance(const LandmarkField& field) {
  const std::size_t n = visible_.size();
  slot_.resize(std::size_t(field.size()), -1);
  covariance_.resize(4 * n * n);
  known_.assign(n * n, 0);
  Eigen::Map<Eigen::MatrixXd> P(covariance_.data(), Eigen::Index(2 * n), Eigen::Index(2 * n));
  for (std::size_t i = 0; i < n; ++i) slot_[std::size_t(visible_[i].index)] = static_cast<int>(i);

  std::size_t pairs = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const int index = visible_[i].index;
    P.block<2, 2>(Eigen::Index(2 * i), Eigen::Index(2 * i)) = field.covariance(index);
    for (const auto* pair = field.pairsBegin(index); pair != field.pairsEnd(index); ++pair) {
      const int other = slot_[std::size_t(pair->second)];
      if (other < 0) continue;
      const auto j = std::size_t(other);
      if (j > i) {
        P.block<2, 2>(Eigen::Index(2 * j), Eigen::Index(2 * i)) = pair->block.transpose();
      } else {
        P.block<2, 2>(Eigen::Index(2 * i), Eigen::Index(2 * j)) = pair->block;
      }
      known_[i * n + j] = known_[j * n + i] = 1;
      ++pairs;
    }
  }
  all_known_ = 2 * pairs == n * (n - 1);
  if (n == 0) all_known_ = true;
  for (const Visible& visible : visible_) slot_[std::size_t(visible.index)] = -1;
}

AchievableInformation InformationEvaluator::ofHeading(double heading_rad) {
  subset_.clear();
  for (std::size_t i = 0; i < visible_.size(); ++i) {
    if (isInField(visible_[i].view, heading_rad)) subset_.push_back(static_cast<int>(i));
  }
  AchievableInformation information = ofSubset();
  information.heading_rad = heading_rad;
  return information;
}

bool InformationEvaluator::isInField(const RegionView& view, double heading_rad) const {
  if (config_.sensor.field_of_view_rad >= kAllAround_rad) return true;
  const double half = 0.5 * config_.sensor.field_of_view_rad;
  const double bearing = wrapAngle(view.bearing_rad - heading_rad);
  return bearing + view.left_rad <= half && bearing - view.right_rad >= -half;
}

/// The set of landmarks in view changes only where one enters or leaves as the sensor turns. More
/// landmarks never inform less, so the best heading lies between an entry and the next exit, and
/// the worst between an exit and the next entry.
AchievableInformation InformationEvaluator::ofExtremeHeading(bool best) {
  const double half = 0.5 * config_.sensor.field_of_view_rad;
  events_.clear();
  for (const Visible& visible : visible_) {
    const RegionView& view = visible.view;
    if (view.left_rad + view.right_rad > 2.0 * half) continue;
    events_.push_back({wrapAngle(view.bearing_rad + view.left_rad - half), true});
    events_.push_back({wrapAngle(view.bearing_rad - view.right_rad + half), false});
  }
  if (events_.empty()) return ofHeading(0.0);
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return a.heading_rad != b.heading_rad ? a.heading_rad < b.heading_rad : a.enters > b.enters;
  });
  AchievableInformation extreme;
  bool is_first = true;
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const Event& from = events_[i];
    const Event& to = events_[(i + 1) % events_.size()];
    if (from.enters != best || to.enters == best) continue;
    const double turn = i + 1 < events_.size() ? 0.0 : 2.0 * kPi;
    const AchievableInformation here =
        ofHeading(wrapAngle(0.5 * (from.heading_rad + to.heading_rad + turn)));
    if (is_first || (best ? here.value > extreme.value : here.value < extreme.value)) {
      extreme = here;
    }
    is_first = false;
  }
  return extreme;
}

void InformationEvaluator::leaveOutUnknownPairs() {
  const std::size_t n = visible_.size();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < subset_.size(); ++i) {
    const auto candidate = std::size_t(subset_[i]);
    const bool is_known =
        std::all_of(subset_.begin(), subset_.begin() + std::ptrdiff_t(kept),
                    [&](int other) { return known_[candidate * n + std::size_t(other)] != 0; });
    if (is_known) subset_[kept++] = subset_[i];
  }
  counts_.left_out += subset_.size() - kept;
  subset_.resize(kept);
}

/// (29) to (35) for the landmarks of subset_. With r c = dx and r s = dy of the landmark from the
/// sensor, H_v needs no angles.
AchievableInformation InformationEvaluator::ofSubset() {
  if (!all_known_) leaveOutUnknownPairs();
  AchievableInformation information;
  information.landmarks = static_cast<int>(subset_.size());
  if (subset_.empty()) return information;

  const auto n = Eigen::Index(subset_.size()), all = Eigen::Index(visible_.size());
  const Eigen::Map<const Eigen::MatrixXd> P(covariance_.data(), 2 * all, 2 * all);
  work_.resize(std::size_t(4 * n * n + 6 * n));
  Eigen::Map<Eigen::MatrixXd> R(work_.data(), 2 * n, 2 * n);
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>> H(work_.data() + 4 * n * n, 2 * n, 3);
  const double range_variance = config_.sensor.range_deviation_m * config_.sensor.range_deviation_m;
  const double bearing_variance =
      config_.sensor.bearing_deviation_rad * config_.sensor.bearing_deviation_rad;

  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index a = subset_[std::size_t(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      R.block<2, 2>(2 * i, 2 * j) = P.block<2, 2>(2 * a, 2 * Eigen::Index(subset_[std::size_t(j)]));
    }
    const Eigen::Vector2d& d = visible_[std::size_t(a)].offset;
    const Eigen::Vector2d across(-d.y(), d.x());
    // (35), with H_eta = [c, -r s; s, +r c].
    R.block<2, 2>(2 * i, 2 * i) += range_variance / d.squaredNorm() * d * d.transpose() +
                                   bearing_variance * across * across.transpose();
    H.block<2, 2>(2 * i, 0).setIdentity();
    H.block<2, 1>(2 * i, 2) = across;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(R);
  if (cholesky.info() != Eigen::Success) {
    ++counts_.unusable;
    return information;
  }
  cholesky.matrixL().solveInPlace(H);
  information.matrix = H.transpose() * H;
  // One landmark leaves a direction free, whatever rounding says.
  information.value = n < 2 && config_.measure != "trace" ? 0.0 : measure_.of(information.matrix);
  return information;
}

}  // namespace hymm::core
