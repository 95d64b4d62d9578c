#include "relocaliser/box_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/angles.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

constexpr double kNothing = -std::numeric_limits<double>::infinity();

// The last level: points move by so much of the smallest deviation. Bounds exceed the likelihood by
// a few percent of a nat a point there.
constexpr double kLeafShare = 1.0 / 32.0;

// Bounds of boxes in which points move by more than this are looked up in tables; others are few,
// and are computed.
constexpr double kLeastTabled_m = 0.5;

// Steps that a cell takes of a table that a landmark is entered into: an exponential function.
constexpr std::size_t kStepsOfCell = 5;

}  // namespace

BoxBounds::BoxBounds(const std::vector<LocalLandmark>& landmarks,
                     const std::vector<ObservedPoint>& points, double clutter_per_m2)
    : bounds_(makeBounds(landmarks, points, clutter_per_m2)) {
  takePoints(points);
}

PointBounds BoxBounds::makeBounds(const std::vector<LocalLandmark>& landmarks,
                                  const std::vector<ObservedPoint>& points, double clutter_per_m2) {
  for (const ObservedPoint& point : points) index_.try_emplace(point.deviation_m, index_.size());
  std::vector<double> deviations(index_.size());
  for (const auto& [deviation_m, index] : index_) deviations[index] = deviation_m;
  return {landmarks, deviations, clutter_per_m2};
}

void BoxBounds::takePoints(const std::vector<ObservedPoint>& points) {
  for (const ObservedPoint& point : points) {
    middle_ += point.p_base_point.cast<double>() / static_cast<double>(points.size());
  }
  for (const ObservedPoint& point : points) {
    const Vector2d arm = point.p_base_point.cast<double>() - middle_;
    points_.push_back({arm, index_.at(point.deviation_m)});
    longest_m_ = std::max(longest_m_, arm.norm());
  }
}

Eigen::AlignedBox2d BoxBounds::landmarkBox() const {
  const Vector2d far = Vector2d::Constant(bounds_.reach_m());
  return {Vector2d(bounds_.landmarkBox().min() - far), Vector2d(bounds_.landmarkBox().max() + far)};
}

double BoxBounds::halfSide_m(double radius_m) { return radius_m / std::sqrt(8.0); }

double BoxBounds::halfYaw_rad(double radius_m) const {
  return 0.5 * radius_m / std::max(1.0, longest_m_);
}

void BoxBounds::makeLevels(double coarsest_m, double half_yaw_rad) {
  const PointTree tree(points_);
  const double finest_m = index_.begin()->first;
  double computed_m = 0.0;
  for (double share = 1.0;; share /= 2.0) {
    const double radius_m = coarsest_m * share;
    Level level;
    level.half_m = halfSide_m(radius_m);
    level.half_yaw_rad = half_yaw_rad * share;
    if (radius_m >= kLeastTabled_m) level.tables = bounds_.tables(radius_m);
    if (!level.isTabled()) computed_m = std::max(computed_m, radius_m);
    // No group is so large that its bound would be looser than those of its points.
    level.groups = tree.cut([&](const PointGroup& group) {
      return level.isTabled() && movesOf(level, group) <= radius_m;
    });
    divideGroups(level);
    worth_.resize(std::max(worth_.size(), level.parts.size()));
    looked_up_.resize(std::max(looked_up_.size(), level.groups.size()));
    levels_.push_back(std::move(level));
    if (radius_m <= kLeafShare * finest_m) break;
  }
  bounds_.prepareNear(computed_m);
  sums_.assign(levels_.size(), std::vector<double>(points_.size() + 1, 0.0));
}

/// By how much a place of one of the group's points, at a pose of the box, is off the place of the
/// group's middle at the middle of the box.
double BoxBounds::movesOf(const Level& level, const PointGroup& group) {
  return level.half_m * std::sqrt(2.0) + group.longest_m * level.half_yaw_rad + group.within_m;
}

void BoxBounds::divideGroups(Level& level) const {
  level.part_of.resize(points_.size());
  for (const PointGroup& group : level.groups) {
    const std::size_t first = level.parts.size();
    level.first_parts.push_back(first);
    for (std::size_t k = group.begin; k < group.end; ++k) {
      std::size_t part = first;
      while (part < level.parts.size() && level.parts[part].deviation != points_[k].deviation) {
        ++part;
      }
      if (part == level.parts.size()) level.parts.push_back({points_[k].deviation, 0.0});
      level.parts[part].count += 1.0;
      level.part_of[k] = part;
    }
  }
  level.first_parts.push_back(level.parts.size());
}

std::optional<std::size_t> BoxBounds::prepare() {
  for (; filled_ < levels_.size(); ++filled_) {
    if (const auto cells = bounds_.fill(levels_[filled_].tables)) return kStepsOfCell * *cells;
  }
  if (most_.empty()) most_ = mostOfAll();
  return std::nullopt;
}

std::vector<double> BoxBounds::mostOfAll() const {
  const Level& level = levels_.front();
  std::vector<double> greatest;
  for (std::size_t i = 0; i < index_.size(); ++i) {
    const auto* table = level.isTabled() ? &level.tables.values[i] : nullptr;
    greatest.push_back(table == nullptr
                           ? bounds_.greatest(i)
                           : static_cast<double>(*std::max_element(table->begin(), table->end())));
  }
  std::vector<double> most{0.0};
  for (const ArmPoint& point : points_) most.push_back(most.back() + greatest[point.deviation]);
  return most;
}

double BoxBounds::bound(std::size_t level, const PoseBox& box, double needed) {
  const std::vector<double>& most = level == 0 ? most_ : sums_[level - 1];
  double sum = most.back();
  if (!mayExceed(levels_[level], box, most, needed, sum)) return kNothing;
  if (!mayExceedByClass(levels_[level], needed, sum)) return kNothing;
  return sumUp(levels_[level], most, sums_[level]);
}

/// Begins with what all points are worth at most, and takes off what each group loses. Points of
/// several classes are looked up in the table for any of them: most boxes are excluded by that.
bool BoxBounds::mayExceed(const Level& level, const PoseBox& box, const std::vector<double>& most,
                          double needed, double& sum) {
  const Eigen::Matrix2d R = Pose2{0.0, 0.0, box.yaw_rad}.rotation();
  for (std::size_t i = 0; i < level.groups.size(); ++i) {
    const PointGroup& group = level.groups[i];
    const double most_of_group = most[group.end] - most[group.begin];
    const Vector2d place = box.middle + R * group.arm;
    const std::int64_t cell = level.isTabled() ? level.tables.raster.cellOf(place) : 0;
    const bool is_worthless = most_of_group <= 0.0 || cell < 0;
    const double worth = is_worthless ? 0.0 : boundOfPoint(level, group, place, cell);
    const double value = std::min(most_of_group, static_cast<double>(group.size()) * worth);
    for (std::size_t j = level.first_parts[i]; j < level.first_parts[i + 1]; ++j) worth_[j] = worth;
    looked_up_[i] = {value, cell};
    sum -= most_of_group - value;
    ++used_;
    if (sum <= needed) return false;
  }
  return true;
}

/// Of any point of the group.
double BoxBounds::boundOfPoint(const Level& level, const PointGroup& group, const Vector2d& place,
                               std::int64_t cell) const {
  const std::size_t any = index_.size();
  const std::size_t deviation = group.is_of_one_class ? points_[group.begin].deviation : any;
  if (!level.isTabled()) return bounds_.near(deviation, place, movesOf(level, group));
  return static_cast<double>(level.tables.values[deviation][static_cast<std::size_t>(cell)]);
}

/// The points of several classes again, each in its class's table.
bool BoxBounds::mayExceedByClass(const Level& level, double needed, double& sum) {
  for (std::size_t i = 0; i < level.groups.size(); ++i) {
    const LookedUp& before = looked_up_[i];
    if (level.groups[i].is_of_one_class || before.value <= 0.0) continue;
    double value = 0.0;
    for (std::size_t j = level.first_parts[i]; j < level.first_parts[i + 1]; ++j) {
      const Part& part = level.parts[j];
      const auto& table = level.tables.values[part.deviation];
      worth_[j] = static_cast<double>(table[static_cast<std::size_t>(before.cell)]);
      value += part.count * worth_[j];
      ++used_;
    }
    sum -= std::max(0.0, before.value - value);
    if (sum <= needed) return false;
  }
  return true;
}

/// No point is worth more than it was in the larger box.
double BoxBounds::sumUp(const Level& level, const std::vector<double>& most,
                        std::vector<double>& sums) {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    sums[k + 1] = sums[k] + std::min(worth_[level.part_of[k]], most[k + 1] - most[k]);
  }
  return sums.back();
}

double BoxBounds::valueAt(const PoseBox& box) {
  const Eigen::Matrix2d R = Pose2{0.0, 0.0, box.yaw_rad}.rotation();
  double sum = 0.0;
  for (const ArmPoint& point : points_) {
    sum += bounds_.near(point.deviation, box.middle + R * point.arm, 0.0);
  }
  used_ += points_.size();
  return sum;
}

}  // namespace hymm::core
