#include "relocaliser/rival_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "common/angles.h"
#include "relocaliser/point_bounds.h"
#include "relocaliser/prior_limit.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

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

// Steps that a box takes beside the bounds on points.
constexpr std::size_t kStepsOfBox = 10;

// The same of a cell of a table that a landmark is entered into.
constexpr std::size_t kStepsOfCell = 2;

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

}  // namespace

class RivalSearch::Boxes {
 public:
  explicit Boxes(RivalQuestion question)
      : question_(std::move(question)),
        prior_(question_.prior, question_.prior_deviations),
        bounds_(makeBounds()) {
    takePoints();
    makeLevels();
    if (domain().isEmpty()) kind_ = Kind::kNoRival;
  }

  std::optional<RivalAnswer> work(std::size_t steps) {
    steps_ = 0;
    while (!kind_ && steps_ < steps) goOn();
    if (!kind_) return std::nullopt;
    return RivalAnswer{*kind_, used_};
  }

 private:
  using Kind = RivalAnswer::Kind;
  enum class Stage { kTables, kRoots, kBoxes };

  struct Point {
    Vector2d arm;  ///< from the middle of the points
    std::size_t deviation = 0;
  };
  struct Root {
    double bound = 0.0;
    std::size_t number = 0;
    /// The greatest bound comes first; of equal ones the first.
    bool operator<(const Root& other) const {
      return bound != other.bound ? bound < other.bound : number > other.number;
    }
  };
  /// A box that is being split.
  struct Split {
    Box box;
    int part = 0;  ///< that comes next
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
    const auto yaws =
        static_cast<std::size_t>(std::lround(yawReach() / levels_.front().half_yaw_rad));
    const Vector2d counts = squares(coarsest_m);
    root_count_ =
        yaws * static_cast<std::size_t>(counts.x()) * static_cast<std::size_t>(counts.y());
    unlimited_.assign(points_.size() + 1, kUnlimited);
    unlimited_.back() = 0.0;
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

  void goOn() {
    if (stage_ == Stage::kTables) {
      fillTables();
    } else if (stage_ == Stage::kRoots) {
      tryRoot();
    } else if (splits_.empty()) {
      takeRoot();
    } else {
      tryPart();
    }
  }

  void fillTables() {
    while (filled_ < levels_.size()) {
      const std::optional<std::size_t> cells = bounds_.fill(levels_[filled_].tables);
      if (cells) {
        steps_ += kStepsOfCell * *cells;
        return;
      }
      ++filled_;
    }
    most_ = mostOfAll();
    stage_ = Stage::kRoots;
  }

  void tryRoot() {
    if (next_root_ == root_count_) {
      stage_ = Stage::kBoxes;
      return;
    }
    steps_ += kStepsOfBox;
    const std::size_t number = next_root_++;
    const Box box = rootBox(number);
    if (isUsedUp()) {
      stage_ = Stage::kBoxes;
      return;
    }
    if (isExcluded(levels_.front(), box)) return;
    const double most_here = bound(0, box, most_);
    if (most_here <= question_.log_likelihood) return;
    roots_.push_back({most_here, number});
    std::push_heap(roots_.begin(), roots_.end());
  }

  Box rootBox(std::size_t number) const {
    const Level& level = levels_.front();
    const auto across = static_cast<std::size_t>(squares(level.radius_m).x());
    const auto along = static_cast<std::size_t>(squares(level.radius_m).y());
    const auto odd = [](std::size_t count) { return static_cast<double>(2 * count + 1); };
    const Vector2d place(odd(number % across), odd(number / across % along));
    const double turn = odd(number / across / along) * level.half_yaw_rad;
    return {domain().min() + level.half_m * place, prior_.mean().yaw_rad - yawReach() + turn};
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
      ++steps_;
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

  void takeRoot() {
    if (isUsedUp()) {
      kind_ = Kind::kUndecided;
    } else if (roots_.empty()) {
      kind_ = Kind::kNoRival;
    } else {
      std::pop_heap(roots_.begin(), roots_.end());
      const Box box = rootBox(roots_.back().number);
      roots_.pop_back();
      bound(0, box, unlimited_);
      split(box);
    }
  }

  /// Of a box whose own bound is in remaining_.
  void split(const Box& box) {
    splits_.push_back({box, 0});
    if (splits_.size() == levels_.size()) kind_ = Kind::kRival;
  }

  void tryPart() {
    if (splits_.back().part == kParts) {
      splits_.pop_back();
      return;
    }
    steps_ += kStepsOfBox;
    const std::size_t depth = splits_.size();
    const Level& level = levels_[depth];
    const Box& box = splits_.back().box;
    const int part = splits_.back().part++;
    const auto side = [&](int bit) { return (part & bit) != 0 ? 1.0 : -1.0; };
    const Box child{box.middle + level.half_m * Vector2d(side(1), side(2)),
                    box.yaw_rad + side(4) * level.half_yaw_rad};
    if (isExcluded(level, child)) return;
    if (isUsedUp()) {
      kind_ = Kind::kUndecided;
    } else if (bound(depth, child, remaining_[depth - 1]) > question_.log_likelihood) {
      if (level.tables.values.empty() && isRival(child)) {
        kind_ = Kind::kRival;
      } else {
        split(child);
      }
    }
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
    steps_ += points_.size();
    return sum > question_.log_likelihood;
  }

  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  static constexpr int kParts = 8;

  RivalQuestion question_;
  PriorLimit prior_;
  std::map<double, std::size_t> index_;  ///< of the points' deviations
  PointBounds bounds_;
  Vector2d middle_ = Vector2d::Zero();  ///< of the points, base frame
  std::vector<Point> points_;
  double longest_m_ = 0.0;  ///< arm
  std::vector<Level> levels_;
  std::vector<std::vector<double>> remaining_;  ///< by level: of the points from each on
  std::vector<double> unlimited_, most_;        ///< the same, not known, and anywhere
  Stage stage_ = Stage::kTables;
  std::size_t filled_ = 0;  ///< levels
  std::size_t root_count_ = 0;
  std::size_t next_root_ = 0;  ///< to be looked at
  std::vector<Root> roots_;    ///< to be split, as a heap
  std::vector<Split> splits_;  ///< one a level, from the root on
  std::optional<Kind> kind_;
  std::size_t used_ = 0;   ///< bounds on points
  std::size_t steps_ = 0;  ///< of the piece
};

RivalSearch::RivalSearch(RivalQuestion question) {
  const bool explains_nothing = question.landmarks.empty() || question.points.empty();
  if (!(question.log_likelihood >= 0.0)) {
    answer_ = {RivalAnswer::Kind::kRival, 0};
  } else if (explains_nothing) {
    answer_ = {RivalAnswer::Kind::kNoRival, 0};
  } else {
    boxes_ = std::make_unique<Boxes>(std::move(question));
  }
}

RivalSearch::~RivalSearch() = default;
RivalSearch::RivalSearch(RivalSearch&& other) noexcept = default;
RivalSearch& RivalSearch::operator=(RivalSearch&& other) noexcept = default;

std::optional<RivalAnswer> RivalSearch::work(std::size_t steps) {
  if (answer_) return answer_;
  answer_ = boxes_->work(steps);
  if (answer_) boxes_.reset();
  return answer_;
}

RivalAnswer findRival(RivalQuestion question) {
  RivalSearch search(std::move(question));
  return *search.work(std::numeric_limits<std::size_t>::max());
}

}  // namespace hymm::core
