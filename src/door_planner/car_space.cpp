#include "door_planner/car_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/DubinsStateSpace.h>
#include <ompl/base/spaces/ReedsSheppStateSpace.h>
#include <ompl/base/terminationconditions/IterationTerminationCondition.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

namespace hymm::core {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kChecked_m = 0.2;        ///< between poses of a motion that are asked for
constexpr double kLongestMotion_m = 8.0;  ///< of the tree
constexpr double kShortest_m = 1e-9;      ///< of a piece that counts

void set(ob::State* state, const Pose2& pose) {
  state->as<ob::SE2StateSpace::StateType>()->setXY(pose.x_m, pose.y_m);
  state->as<ob::SE2StateSpace::StateType>()->setYaw(pose.yaw_rad);
}

Pose2 poseOf(const ob::State* state) {
  const auto* se2 = state->as<ob::SE2StateSpace::StateType>();
  return {se2->getX(), se2->getY(), se2->getYaw()};
}

/// Draws from where the way is expected.
class MazeSampler : public ob::StateSampler {
 public:
  MazeSampler(const ob::StateSpace* space, const CarSpace::Maze& maze, std::uint64_t seed)
      : ob::StateSampler(space), maze_(maze), generator_(seed) {}

  void sampleUniform(ob::State* state) override {
    set(state, maze_.sample(generator_));
    space_->enforceBounds(state);
  }
  void sampleUniformNear(ob::State* state, const ob::State*, double) override {
    sampleUniform(state);
  }
  void sampleGaussian(ob::State* state, const ob::State*, double) override { sampleUniform(state); }

 private:
  const CarSpace::Maze& maze_;
  RandomGenerator generator_;
};

/// OMPL seeds its planners from one global sequence; this one finds the same wherever it stands in
/// that. Neighbours are chosen by a distance that is cheap to compute; costs are lengths of curves.
class RepeatableRrtStar : public og::RRTstar {
 public:
  RepeatableRrtStar(const ob::SpaceInformationPtr& space, double radius_m, std::uint64_t seed)
      : RRTstar(space), radius_m_(radius_m) {
    rng_.setLocalSeed(static_cast<std::uint_fast32_t>(seed));
    setNearestNeighbors<ompl::NearestNeighborsLinear>();
    setRange(kLongestMotion_m);
  }

  void setup() override {
    RRTstar::setup();
    nn_->setDistanceFunction([this](const Motion* a, const Motion* b) {
      const Pose2 one = poseOf(a->state), other = poseOf(b->state);
      return (one.position() - other.position()).norm() +
             radius_m_ * std::abs(wrapAngle(one.yaw_rad - other.yaw_rad));
    });
  }

 private:
  double radius_m_;
};

/// Asks along a curve that is computed once; OMPL's own computes it anew for each pose.
class CurveValidator : public ob::MotionValidator {
 public:
  CurveValidator(const ob::SpaceInformationPtr& information, const CarSpace& space,
                 const CarSpace::Maze& maze)
      : ob::MotionValidator(information), space_(space), maze_(maze) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    const std::vector<CarPose> poses = space_.shortest(poseOf(from), poseOf(to)).poses(kChecked_m);
    return std::all_of(poses.begin(), poses.end(),
                       [&](const CarPose& pose) { return maze_.is_free(pose.T_map_base); });
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>&) const override {
    return checkMotion(from, to);
  }

 private:
  const CarSpace& space_;
  const CarSpace::Maze& maze_;
};

}  // namespace

struct CarSpace::Space {
  virtual ~Space() = default;
  virtual std::shared_ptr<ob::SE2StateSpace> make() const = 0;
  virtual std::vector<CurvePiece> pieces(const ob::State* from, const ob::State* to) const = 0;
  virtual const ob::SE2StateSpace& space() const = 0;
};

namespace {

struct ReedsShepp : CarSpace::Space {
  explicit ReedsShepp(double radius_m) : radius(radius_m), states(radius_m) {}
  std::shared_ptr<ob::SE2StateSpace> make() const override {
    return std::make_shared<ob::ReedsSheppStateSpace>(radius);
  }
  const ob::SE2StateSpace& space() const override { return states; }
  std::vector<CurvePiece> pieces(const ob::State* from, const ob::State* to) const override {
    const ob::ReedsSheppStateSpace::ReedsSheppPath path = states.reedsShepp(from, to);
    std::vector<CurvePiece> pieces;
    for (std::size_t i = 0; i < 5 && path.type_[i] != ob::ReedsSheppStateSpace::RS_NOP; ++i) {
      const double side = path.type_[i] == ob::ReedsSheppStateSpace::RS_LEFT    ? 1.0
                          : path.type_[i] == ob::ReedsSheppStateSpace::RS_RIGHT ? -1.0
                                                                                : 0.0;
      pieces.push_back({side / radius, path.length_[i] * radius});
    }
    return pieces;
  }
  double radius;
  ob::ReedsSheppStateSpace states;
};

struct Dubins : CarSpace::Space {
  explicit Dubins(double radius_m) : radius(radius_m), states(radius_m) {}
  std::shared_ptr<ob::SE2StateSpace> make() const override {
    return std::make_shared<ob::DubinsStateSpace>(radius);
  }
  const ob::SE2StateSpace& space() const override { return states; }
  std::vector<CurvePiece> pieces(const ob::State* from, const ob::State* to) const override {
    const ob::DubinsStateSpace::DubinsPath path = states.dubins(from, to);
    std::vector<CurvePiece> pieces;
    for (std::size_t i = 0; i < 3; ++i) {
      const double side = path.type_[i] == ob::DubinsStateSpace::DUBINS_LEFT    ? 1.0
                          : path.type_[i] == ob::DubinsStateSpace::DUBINS_RIGHT ? -1.0
                                                                                : 0.0;
      pieces.push_back({side / radius, path.length_[i] * radius});
    }
    return pieces;
  }
  double radius;
  ob::DubinsStateSpace states;
};

}  // namespace

CarSpace::CarSpace(double turning_radius_m, bool can_reverse)
    : turning_radius_m_(turning_radius_m) {
  ompl::msg::noOutputHandler();
  if (can_reverse) {
    space_ = std::make_unique<ReedsShepp>(turning_radius_m);
  } else {
    space_ = std::make_unique<Dubins>(turning_radius_m);
  }
}

CarSpace::~CarSpace() = default;

CarCurve CarSpace::shortest(const Pose2& from, const Pose2& to) const {
  const ob::SE2StateSpace& space = space_->space();
  ob::State* const a = space.allocState();
  ob::State* const b = space.allocState();
  set(a, from);
  set(b, to);
  CarCurve curve{from, to, {}};
  for (const CurvePiece& piece : space_->pieces(a, b)) {
    if (std::abs(piece.length_m) > kShortest_m) curve.pieces.push_back(piece);
  }
  space.freeState(a);
  space.freeState(b);
  return curve;
}

std::optional<std::vector<Pose2>> CarSpace::search(const Pose2& start,
                                                   const std::vector<Pose2>& goals,
                                                   const Maze& maze, const Effort& effort) const {
  if (goals.empty()) return std::nullopt;
  const std::shared_ptr<ob::SE2StateSpace> space = space_->make();
  ob::RealVectorBounds bounds(2);
  for (unsigned axis = 0; axis < 2; ++axis) {
    bounds.setLow(axis, maze.low[Eigen::Index(axis)]);
    bounds.setHigh(axis, maze.high[Eigen::Index(axis)]);
  }
  space->setBounds(bounds);
  space->setStateSamplerAllocator([&](const ob::StateSpace* of) {
    return std::make_shared<MazeSampler>(of, maze, effort.seed);
  });
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return maze.is_free(poseOf(state)); });
  information->setMotionValidator(std::make_shared<CurveValidator>(information, *this, maze));
  information->setup();

  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<ob::SE2StateSpace> begin(space);
  set(begin.get(), start);
  problem->addStartState(begin);
  const auto ends = std::make_shared<ob::GoalStates>(information);
  for (const Pose2& goal : goals) {
    ob::ScopedState<ob::SE2StateSpace> end(space);
    set(end.get(), goal);
    ends->addState(end);
  }
  problem->setGoal(ends);
  problem->setOptimizationObjective(
      std::make_shared<ob::PathLengthOptimizationObjective>(information));
  RepeatableRrtStar planner(information, turning_radius_m_, effort.seed);
  planner.setProblemDefinition(problem);
  planner.setup();
  ob::IterationTerminationCondition iterations(static_cast<unsigned>(effort.iterations));
  planner.solve(ob::PlannerTerminationCondition(
      [&] { return iterations.eval() || (effort.stop && effort.stop()); }));
  if (!problem->hasExactSolution()) return std::nullopt;
  std::vector<Pose2> poses;
  for (const ob::State* state : problem->getSolutionPath()->as<og::PathGeometric>()->getStates()) {
    poses.push_back(poseOf(state));
  }
  return poses;
}

}  // namespace hymm::core
