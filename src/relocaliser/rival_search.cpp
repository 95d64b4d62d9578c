#include "relocaliser/rival_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "common/angles.h"
#include "relocaliser/point_bounds.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// By how much a point moves within the boxes of the first level, at most. Larger boxes exclude
// nothing where landmarks stand as near as that; each level halves it.
constexpr double kCoarsest_m = 4.0;

// Boxes of the first level, at most: where there would be more, it is coarser.
constexpr double kMostRoots = 2e5;

// The last level: points move by so much of the smallest deviation. Bounds exceed the likelihood by
// a few percent of a nat a point there.
constexpr double kLeafShare = 1.0 / 32.0;

// Bounds of boxes in which points move by more than this are looked up in tables; others are few,
// and are computed.
constexpr double kLeastTabled_m = 0.5;

/// The ellipsoid that the prior leaves.
class PriorLimit {
 public:
  explicit PriorLimit(const RivalQuestion& question) : limit_(question.prior_deviations) {
    if (!question.prior) return;
    mean_ = question.prior->mean;
    // A prior that is exact in some direction still has some width.
    const Eigen::Matrix3d P = question.prior->covariance + 1e-6 * Eigen::Matrix3d::Identity();
    factor_.emplace(P);
    const Eigen::Matrix3d inverse = P.inverse();
    per_m_ = std::sqrt(greatestVariance(inverse.topLeftCorner<2, 2>()));
    per_rad_ = std::sqrt(inverse(2, 2));
    reach_m_ = limit_ * std::sqrt(greatestVariance(P.topLeftCorner<2, 2>()));
    reach_rad_ = limit_ * std::sqrt(P(2, 2));
  }
  /// Whether no pose that is nearer than these to `pose` is within it.
  bool excludes(const Pose2& pose, double within_m, double within_rad) const {
    if (!factor_) return false;
    Vector3d d = pose.vector() - mean_.vector();
    d[2] = wrapAngle(d[2]);
    double deviations = std::sqrt(d.dot(factor_->solve(d)));
    if (std::abs(d[2]) + within_rad > kPi) {  // some of them are nearer the other way round
      d[2] -= std::copysign(2.0 * kPi, d[2]);
      deviations = std::min(deviations, std::sqrt(d.dot(factor_->solve(d))));
    }
    return deviations - within_m * per_m_ - within_rad * per_rad_ > limit_;
  }
  bool isOn() const { return factor_.has_value(); }
  const Pose2& mean() const { return mean_; }
  double reach_m() const { return reach_m_; }
  double reach_rad() const { return reach_rad_; }

 private:
  double limit_;
  Pose2 mean_;
  std::optional<Eigen::LLT<Eigen::Matrix3d>> factor_;
  double per_m_ = 0.0, per_rad_ = 0.0;  ///< most deviations that a metre or a radian makes
  double reach_m_ = 0.0, reach_rad_ = 0.0;
};

/// Poses: where the middle of the points comes to lie, within a square, and the heading.
struct Box {
  Vector2d middle = Vector2d::Zero();
  double yaw_rad = 0.0;
};

struct Level {
  double radius_m = 0.0;  ///< points move by no more within a box
  double half_m = 0.0;    ///< of the square's side
  double half_yaw_rad = 0.0;
  PointBounds::Tables tables;  ///< without values: bounds are computed
};

class RivalSearch {
 public:
  explicit RivalSearch(const RivalQuestion& question)
      : question_(question), prior_(question), bounds_(makeBounds()) {
    takePoints();
    makeLevels();
  }

  RivalAnswer answer() {
    RivalAnswer answer;
    answer.kind = search();
    answer.bounds = used_;
    return answer;
  }

 private:
  using Kind = RivalAnswer::Kind;

  struct Point {
    Vector2d arm;  ///< from the middle of the points
    std::size_t deviation = 0;
  };
  struct Root {
    Box box;
    double bound = 0.0;
  };

  PointBounds makeBounds() {
    for (const ObservedPoint& point : question_.points) {
      index_.try_emplace(point.deviation_m, index_.size());
    }
    std::vector<double> deviations(index_.size());
    for (const auto& [deviation_m, index] : index_) deviations[index] = deviation_m;
    return {question_.landmarks, deviations,
            clutterPerM2(question_.points.size(), question_.view_m2, question_.density)};
  }

  // Turned about their middle, points move least.
  void takePoints() {
    for (const ObservedPoint& point : question_.points) {
      middle_ += point.p_base_point.cast<double>() / static_cast<double>(question_.points.size());
    }
    for (const ObservedPoint& point : question_.points) {
      const Vector2d arm = point.p_base_point.cast<double>() - middle_;
      points_.push_back({arm, index_.at(point.deviation_m)});
      longest_m_ = std::max(longest_m_, arm.norm());
    }
  }

  void makeLevels() {
    const double finest_m = index_.empty() ? 1.0 : index_.begin()->first;
    double coarsest_m = kCoarsest_m;
    while (rootCount(coarsest_m) > kMostRoots) coarsest_m *= 2.0;
    const double half_yaw = yawReach() / yawCount(coarsest_m);
    double radius_m = coarsest_m;
    double computed_m = 0.0;
    for (double share = 1.0;; share /= 2.0) {
      radius_m = coarsest_m * share;
      Level level{radius_m, radius_m / std::sqrt(8.0), half_yaw * share, {}};
      if (radius_m >= kLeastTabled_m) level.tables = bounds_.tables(radius_m);
      if (level.tables.values.empty()) computed_m = std::max(computed_m, radius_m);
      levels_.push_back(std::move(level));
      if (radius_m <= kLeafShare * finest_m) break;
    }
    bounds_.prepareNear(computed_m);
    remaining_.assign(levels_.size(), std::vector<double>(points_.size() + 1, 0.0));
  }

  // Half of a point's motion is left to the heading.
  double halfYaw(double radius_m) const { return 0.5 * radius_m / std::max(1.0, longest_m_); }
  double yawReach() const { return prior_.isOn() ? std::min(kPi, prior_.reach_rad()) : kPi; }
  double yawCount(double radius_m) const {
    return std::max(1.0, std::ceil(yawReach() / halfYaw(radius_m)));
  }
  /// Where the middle of the points can lie: around the landmarks, and where the prior puts it.
  Eigen::AlignedBox2d domain() const {
    const Vector2d far = Vector2d::Constant(longest_m_ + bounds_.reach_m());
    Eigen::AlignedBox2d domain(Vector2d(bounds_.landmarkBox().min() - far),
                               Vector2d(bounds_.landmarkBox().max() + far));
    if (!prior_.isOn()) return domain;
    const Vector2d reach = Vector2d::Constant(prior_.reach_m() + middle_.norm());
    return domain.intersection(
        {Vector2d(prior_.mean().position() - reach), Vector2d(prior_.mean().position() + reach)});
  }
  Vector2d squares(double radius_m) const {
    const double side_m = 2.0 * radius_m / std::sqrt(8.0);
    return (domain().sizes() / side_m).array().ceil().max(1.0);
  }
  double rootCount(double radius_m) const { return squares(radius_m).prod() * yawCount(radius_m); }

  Kind search() {
    if (domain().isEmpty()) return Kind::kNone;
    std::vector<Root> roots = findRoots();
    std::stable_sort(roots.begin(), roots.end(),
                     [](const Root& a, const Root& b) { return a.bound > b.bound; });
    std::vector<double> unlimited(points_.size() + 1, kUnlimited);
    unlimited.back() = 0.0;
    for (const Root& root : roots) {
      if (isUsedUp()) return Kind::kUndecided;
      bound(0, root.box, unlimited);
      const Kind kind = split(0, root.box);
      if (kind != Kind::kNone) return kind;
    }
    return isUsedUp() ? Kind::kUndecided : Kind::kNone;
  }

  std::vector<Root> findRoots() {
    const Level& level = levels_.front();
    const auto yaws = static_cast<int>(std::lround(yawReach() / level.half_yaw_rad));
    const Vector2d counts = squares(level.radius_m);
    const std::vector<double> most = mostOfAll();
    std::vector<Root> roots;
    for (int k = 0; k < yaws; ++k) {
      const double yaw = prior_.mean().yaw_rad - yawReach() + (2 * k + 1) * level.half_yaw_rad;
      for (int v = 0; v < static_cast<int>(counts.y()); ++v) {
        for (int u = 0; u < static_cast<int>(counts.x()); ++u) {
          const Box box{domain().min() + level.half_m * Vector2d(2 * u + 1, 2 * v + 1), yaw};
          if (isUsedUp()) return roots;
          if (isExcluded(level, box)) continue;
          const double most_here = bound(0, box, most);
          if (most_here > question_.log_likelihood) roots.push_back({box, most_here});
        }
      }
    }
    return roots;
  }

  /// What the points from each on are worth at most, anywhere.
  std::vector<double> mostOfAll() const {
    const Level& level = levels_.front();
    std::vector<double> most(points_.size() + 1, 0.0);
    std::vector<double> greatest;
    for (const auto& table : level.tables.values) {
      greatest.push_back(static_cast<double>(*std::max_element(table.begin(), table.end())));
    }
    for (std::size_t k = points_.size(); k-- > 0;) {
      most[k] = most[k + 1] + (greatest.empty() ? kUnlimited : greatest[points_[k].deviation]);
    }
    return most;
  }

  bool isUsedUp() const { return used_ > question_.most_bounds; }

  Pose2 poseOf(const Box& box) const {
    const Pose2 turned{0.0, 0.0, wrapAngle(box.yaw_rad)};
    const Vector2d place = box.middle - turned * middle_;
    return {place.x(), place.y(), turned.yaw_rad};
  }

  /// Whether all of the box is the place believed, or beyond the prior.
  bool isExcluded(const Level& level, const Box& box) const {
    const Pose2 pose = poseOf(box);
    const double moves_m = level.half_m * std::sqrt(2.0) + middle_.norm() * level.half_yaw_rad;
    return isBelieved(pose, moves_m, level.half_yaw_rad) ||
           prior_.excludes(pose, moves_m, level.half_yaw_rad);
  }
  bool isBelieved(const Pose2& pose, double within_m, double within_rad) const {
    const double away_m = (pose.position() - question_.believed.position()).norm();
    const double turn = std::abs(wrapAngle(pose.yaw_rad - question_.believed.yaw_rad));
    return away_m + within_m < question_.distance_m && turn + within_rad < question_.angle_rad;
  }

  /// The most that all points together can be worth in the box; -inf as soon as it is clear that
  /// this is too little. `most_of_rest` holds what the points from each on are worth at most. What
  /// they are worth here is left in remaining_.
  double bound(std::size_t depth, const Box& box, const std::vector<double>& most_of_rest) {
    const Level& level = levels_[depth];
    const Eigen::Matrix2d R = Pose2{0.0, 0.0, box.yaw_rad}.rotation();
    std::vector<double>& values = remaining_[depth];
    double sum = 0.0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Vector2d place = box.middle + R * points_[k].arm;
      values[k] = boundOfPoint(level, points_[k], place);
      sum += values[k];
      ++used_;
      if (sum + most_of_rest[k + 1] <= question_.log_likelihood) return -kUnlimited;
    }
    for (std::size_t k = points_.size(); k-- > 0;) values[k] += values[k + 1];
    return sum;
  }

  double boundOfPoint(const Level& level, const Point& point, const Vector2d& place) const {
    if (level.tables.values.empty()) {
      const double moves_m = level.half_m * std::sqrt(2.0) + point.arm.norm() * level.half_yaw_rad;
      return bounds_.near(point.deviation, place, moves_m);
    }
    const std::int64_t cell = level.tables.raster.cellOf(place);
    if (cell < 0) return 0.0;
    return static_cast<double>(
        level.tables.values[point.deviation][static_cast<std::size_t>(cell)]);
  }

  /// Of a box whose own bound is in remaining_.
  Kind split(std::size_t depth, const Box& box) {
    if (depth + 1 == levels_.size()) return Kind::kRival;
    const Level& level = levels_[depth + 1];
    for (int part = 0; part < 8; ++part) {
      const auto side = [&](int bit) { return (part & bit) != 0 ? 1.0 : -1.0; };
      const Box child{box.middle + level.half_m * Vector2d(side(1), side(2)),
                      box.yaw_rad + side(4) * level.half_yaw_rad};
      if (isExcluded(level, child)) continue;
      if (isUsedUp()) return Kind::kUndecided;
      if (bound(depth + 1, child, remaining_[depth]) <= question_.log_likelihood) continue;
      if (level.tables.values.empty() && isRival(child)) return Kind::kRival;
      const Kind kind = split(depth + 1, child);
      if (kind != Kind::kNone) return kind;
    }
    return Kind::kNone;
  }

  /// Whether the middle of the box is one.
  bool isRival(const Box& box) {
    const Pose2 pose = poseOf(box);
    if (isBelieved(pose, 0.0, 0.0) || prior_.excludes(pose, 0.0, 0.0)) return false;
    const Eigen::Matrix2d R = pose.rotation();
    double sum = 0.0;
    for (const Point& point : points_) {
      sum += bounds_.near(point.deviation, box.middle + R * point.arm, 0.0);
    }
    used_ += points_.size();
    return sum > question_.log_likelihood;
  }

  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

  const RivalQuestion& question_;
  PriorLimit prior_;
  std::map<double, std::size_t> index_;  ///< of the points' deviations
  PointBounds bounds_;
  Vector2d middle_ = Vector2d::Zero();  ///< of the points, base frame
  std::vector<Point> points_;
  double longest_m_ = 0.0;  ///< arm
  std::vector<Level> levels_;
  std::vector<std::vector<double>> remaining_;  ///< by level: of the points from each on
  std::size_t used_ = 0;
};

}  // namespace

RivalAnswer findRival(const RivalQuestion& question) {
  if (!(question.log_likelihood >= 0.0)) return {RivalAnswer::Kind::kRival, 0};
  const bool explains_nothing = question.landmarks.empty() || question.points.empty();
  if (explains_nothing) return {RivalAnswer::Kind::kNone, 0};
  return RivalSearch(question).answer();
}

}  // namespace hymm::core
