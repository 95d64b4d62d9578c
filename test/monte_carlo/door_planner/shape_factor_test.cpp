// How often a path through an LTR is longer than its cost says, with the LTR's corners drawn from
// their joint covariance.

#include <cmath>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "common/random.h"
#include "door_planner/door_planner.h"
#include "door_planner/side_bounds.h"

namespace hymm::core {
namespace {

using Covariance = Eigen::Matrix<double, 6, 6>;
constexpr int kTriangles = 20;
constexpr int kDraws = 20000;
constexpr double kBeyondThreeSigma = 0.00135;  // of a normal distribution, on one side

struct UncertainLtr {
  LtrView view;
  Covariance covariance;

  explicit UncertainLtr(RandomGenerator& generator) {
    do {
      for (Eigen::Vector2d& corner : view.corners) {
        corner = {sampleUniform(generator, 0.0, 20.0), sampleUniform(generator, 0.0, 20.0)};
      }
    } while (turn(view.corners[0], view.corners[1], view.corners[2]) <= 0.0 ||
             smallestAngle(view.corners) < 0.4 || shortestSide(view.corners) < 6.0);
    view.id = 0;
    view.landmark_ids = {0, 1, 2};
    view.alpha_cells = view.beta_cells = 40;
    // Each on its own by some centimetres, all together by metres.
    covariance.setZero();
    for (int k = 0; k < 3; ++k) {
      for (int other = 0; other < 3; ++other) {
        covariance.block<2, 2>(2 * k, 2 * other) += 4.0 * Eigen::Matrix2d::Identity();
      }
      const Eigen::Matrix2d root =
          Eigen::Matrix2d::NullaryExpr([&](auto, auto) { return sampleNormal(generator, 0.05); });
      covariance.block<2, 2>(2 * k, 2 * k) += root * root.transpose();
    }
    view.shape_factor = shapeFactor(view.corners, covariance);
  }

  Eigen::Vector2d middle() const {
    return (view.corners[0] + view.corners[1] + view.corners[2]) / 3.0;
  }
};

/// Share of draws in which the path, fixed in local coordinates, is longer than `limit_m`.
double shareLonger(const UncertainLtr& ltr, const Plan& plan, double limit_m,
                   RandomGenerator& generator) {
  const Covariance root = ltr.covariance.llt().matrixL();
  int longer = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::Matrix<double, 6, 1> shift =
        root * Eigen::Matrix<double, 6, 1>::NullaryExpr(
                   [&](auto) { return sampleNormal(generator, 1.0); });
    const auto places = placeOf(plan.points, [&](int id) -> std::optional<Eigen::Vector2d> {
      return ltr.view.corners[std::size_t(id)] + shift.segment<2>(2 * id);
    });
    double length = 0.0;
    for (std::size_t i = 1; i < places->size(); ++i)
      length += ((*places)[i] - (*places)[i - 1]).norm();
    longer += length > limit_m ? 1 : 0;
  }
  return static_cast<double>(longer) / kDraws;
}

/// A metre straight across the middle, in a direction.
Plan planAcross(const UncertainLtr& ltr, double angle) {
  DoorPlanner planner{DoorPlannerConfig{}};
  planner.setLtrs({ltr.view});
  LtrContent content;
  content.occupancy.assign(std::size_t(gridOf(40, 40).cellCount()), 0.0F);
  planner.setContent(0, content);
  planner.prepare(Eigen::Vector2d::Zero());
  PlanRequest request;
  const Eigen::Vector2d half = 0.5 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  request.start = ltr.middle() - half;
  request.goal = ltr.middle() + half;
  return planner.plan(request);
}

TEST(ShapeFactor, IsExceededNoMoreOftenThanThreeSigmaSay) {
  RandomGenerator generator(11);
  for (int i = 0; i < kTriangles; ++i) {
    const UncertainLtr ltr(generator);
    double worst = 0.0;
    for (int k = 0; k < 8; ++k) {
      const Plan plan = planAcross(ltr, M_PI * k / 8);
      ASSERT_TRUE(plan.ok()) << plan.sentence;
      ASSERT_NEAR(plan.cost_with_uncertainty, ltr.view.shape_factor * plan.length_m, 1e-9);
      worst = std::max(worst, shareLonger(ltr, plan, plan.cost_with_uncertainty, generator));
    }
    // Four deviations of a count of that mean, for the largest of eight.
    const double noise = 4.0 * std::sqrt(kBeyondThreeSigma / kDraws);
    EXPECT_LE(worst, kBeyondThreeSigma + noise) << "triangle " << i;
  }
}

TEST(SideLengthBound, IsExceededByOtherDirectionsMoreOftenThanOneSigmaSays) {
  RandomGenerator generator(11);
  constexpr double kBeyondOneSigma = 0.159;
  double largest = 0.0;
  for (int i = 0; i < kTriangles; ++i) {
    const UncertainLtr ltr(generator);
    for (int k = 0; k < 8; ++k) {
      const Plan plan = planAcross(ltr, M_PI * k / 8);
      const double bound = sideLengthBound(ltr.view.corners, ltr.covariance) * plan.length_m;
      largest = std::max(largest, shareLonger(ltr, plan, bound, generator));
    }
    EXPECT_LE(sideLengthBound(ltr.view.corners, ltr.covariance),
              sideVectorBound(ltr.view.corners, ltr.covariance));
  }
  RecordProperty("largest_share", std::to_string(largest));
  EXPECT_GT(largest, 1.2 * kBeyondOneSigma);
}

}  // namespace
}  // namespace hymm::core
