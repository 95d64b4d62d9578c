#include "relocaliser/rival_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "common/angles.h"
#include "relocaliser/box_bounds.h"
#include "relocaliser/prior_limit.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;

// By how much a point moves within the boxes of the first level, at most. Larger boxes exclude
// nothing where landmarks stand as near as that; each level halves it.
constexpr double kCoarsest_m = 4.0;

// Boxes of the first level, at most: where there would be more, it is coarser.
constexpr double kMostRoots = 2e5;

// Steps that a box takes beside the bounds on groups of points.
constexpr std::size_t kStepsOfBox = 10;

constexpr int kParts = 8;  // of a box

}  // namespace

class RivalSearch::Boxes {
 public:
  explicit Boxes(RivalQuestion question)
      : question_(std::move(question)),
        prior_(question_.prior, question_.prior_deviations),
        bounds_(question_.landmarks, question_.points,
                clutterPerM2(question_.points.size(), question_.view_m2, question_.density)) {
    if (domain().isEmpty()) {
      kind_ = Kind::kNoRival;
      return;
    }
    double coarsest_m = kCoarsest_m;
    while (squares(coarsest_m).prod() * yawCount(coarsest_m) > kMostRoots) coarsest_m *= 2.0;
    bounds_.makeLevels(coarsest_m, yawReach() / yawCount(coarsest_m));
    across_ = static_cast<std::size_t>(squares(coarsest_m).x());
    along_ = static_cast<std::size_t>(squares(coarsest_m).y());
    root_count_ = across_ * along_ * static_cast<std::size_t>(yawCount(coarsest_m));
  }

  std::optional<RivalAnswer> work(std::size_t steps) {
    steps_ = 0;
    used_before_ = bounds_.used();
    while (!kind_ && steps_ + bounds_.used() - used_before_ < steps) goOn();
    if (!kind_) return std::nullopt;
    return RivalAnswer{*kind_, bounds_.used()};
  }

 private:
  using Kind = RivalAnswer::Kind;
  enum class Stage { kTables, kRoots, kBoxes };

  struct Root {
    double bound = 0.0;
    std::size_t number = 0;
    /// The greatest bound comes first; of equal ones the first.
    bool operator<(const Root& other) const {
      return bound != other.bound ? bound < other.bound : number > other.number;
    }
  };
  /// A box that is being split, of the level that it is the number of.
  struct Split {
    PoseBox box;
    int part = 0;  ///< that comes next
  };

  double yawReach() const { return prior_.isOn() ? std::min(kPi, prior_.reach_rad()) : kPi; }
  double yawCount(double radius_m) const {
    return std::max(1.0, std::ceil(yawReach() / bounds_.halfYaw_rad(radius_m)));
  }
  /// Where the middle of the points can lie: around the landmarks, and where the prior puts it.
  Eigen::AlignedBox2d domain() const {
    const Vector2d far = Vector2d::Constant(bounds_.longest_m());
    const Eigen::AlignedBox2d domain(Vector2d(bounds_.landmarkBox().min() - far),
                                     Vector2d(bounds_.landmarkBox().max() + far));
    if (!prior_.isOn()) return domain;
    const Vector2d reach = Vector2d::Constant(prior_.reach_m() + bounds_.middle().norm());
    return domain.intersection(
        {Vector2d(prior_.mean().position() - reach), Vector2d(prior_.mean().position() + reach)});
  }
  Vector2d squares(double radius_m) const {
    const double side_m = 2.0 * BoxBounds::halfSide_m(radius_m);
    return (domain().sizes() / side_m).array().ceil().max(1.0);
  }

  void goOn() {
    if (stage_ == Stage::kTables) {
      const std::optional<std::size_t> steps = bounds_.prepare();
      steps_ += steps.value_or(0);
      if (!steps) stage_ = Stage::kRoots;
    } else if (stage_ == Stage::kRoots) {
      tryRoot();
    } else if (splits_.empty()) {
      takeRoot();
    } else {
      tryPart();
    }
  }

  void tryRoot() {
    if (next_root_ == root_count_ || isUsedUp()) {
      stage_ = Stage::kBoxes;
      return;
    }
    steps_ += kStepsOfBox;
    const std::size_t number = next_root_++;
    const PoseBox box = rootBox(number);
    if (isExcluded(0, box)) return;
    const double most = bounds_.bound(0, box, question_.log_likelihood);
    if (most <= question_.log_likelihood) return;
    roots_.push_back({most, number});
    std::push_heap(roots_.begin(), roots_.end());
  }

  PoseBox rootBox(std::size_t number) const {
    const auto odd = [](std::size_t count) { return static_cast<double>(2 * count + 1); };
    const Vector2d place(odd(number % across_), odd(number / across_ % along_));
    const double turn = odd(number / across_ / along_) * bounds_.half_yaw_rad(0);
    return {domain().min() + bounds_.half_m(0) * place, prior_.mean().yaw_rad - yawReach() + turn};
  }

  void takeRoot() {
    if (isUsedUp()) {
      kind_ = Kind::kUndecided;
    } else if (roots_.empty()) {
      kind_ = Kind::kNoRival;
    } else {
      std::pop_heap(roots_.begin(), roots_.end());
      const PoseBox box = rootBox(roots_.back().number);
      roots_.pop_back();
      bounds_.bound(0, box, question_.log_likelihood);  // which those of its parts go on from
      split(box);
    }
  }

  void split(const PoseBox& box) {
    splits_.push_back({box, 0});
    if (splits_.size() == bounds_.levels()) kind_ = Kind::kRival;
  }

  void tryPart() {
    if (splits_.back().part == kParts) {
      splits_.pop_back();
      return;
    }
    steps_ += kStepsOfBox;
    const std::size_t level = splits_.size();
    const PoseBox child = partOf(splits_.back().box, splits_.back().part++);
    if (isExcluded(level, child)) return;
    if (isUsedUp()) {
      kind_ = Kind::kUndecided;
    } else if (bounds_.bound(level, child, question_.log_likelihood) > question_.log_likelihood) {
      if (!bounds_.isTabled(level) && isRival(child)) {
        kind_ = Kind::kRival;
      } else {
        split(child);
      }
    }
  }

  PoseBox partOf(const PoseBox& box, int part) const {
    const std::size_t level = splits_.size();
    const auto side = [&](int bit) { return (part & bit) != 0 ? 1.0 : -1.0; };
    return {box.middle + bounds_.half_m(level) * Vector2d(side(1), side(2)),
            box.yaw_rad + side(4) * bounds_.half_yaw_rad(level)};
  }

  bool isUsedUp() const { return bounds_.used() > question_.most_bounds; }

  Pose2 poseOf(const PoseBox& box) const {
    const Pose2 turned{0.0, 0.0, wrapAngle(box.yaw_rad)};
    const Vector2d place = box.middle - turned * bounds_.middle();
    return {place.x(), place.y(), turned.yaw_rad};
  }

  /// Whether all of the box is the place believed, or beyond the prior.
  bool isExcluded(std::size_t level, const PoseBox& box) const {
    const Pose2 pose = poseOf(box);
    const double half_yaw = bounds_.half_yaw_rad(level);
    const double moves_m =
        bounds_.half_m(level) * std::sqrt(2.0) + bounds_.middle().norm() * half_yaw;
    return isBelieved(pose, moves_m, half_yaw) || prior_.excludes(pose, moves_m, half_yaw);
  }
  bool isBelieved(const Pose2& pose, double within_m, double within_rad) const {
    const double away_m = (pose.position() - question_.believed.position()).norm();
    const double turn = std::abs(wrapAngle(pose.yaw_rad - question_.believed.yaw_rad));
    return away_m + within_m < question_.distance_m && turn + within_rad < question_.angle_rad;
  }

  /// Whether the middle of the box is one.
  bool isRival(const PoseBox& box) {
    const Pose2 pose = poseOf(box);
    if (isBelieved(pose, 0.0, 0.0) || prior_.excludes(pose, 0.0, 0.0)) return false;
    return bounds_.valueAt(box) > question_.log_likelihood;
  }

  RivalQuestion question_;
  PriorLimit prior_;
  BoxBounds bounds_;
  Stage stage_ = Stage::kTables;
  std::size_t across_ = 0, along_ = 0, root_count_ = 0;
  std::size_t next_root_ = 0;  ///< to be looked at
  std::vector<Root> roots_;    ///< to be split, as a heap
  std::vector<Split> splits_;  ///< by level
  std::optional<Kind> kind_;
  std::size_t steps_ = 0, used_before_ = 0;  ///< of the piece: beside its bounds, and before them
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
