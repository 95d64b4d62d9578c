#include "door_planner/cell_metric.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"
#include "hybrid_map/ltr_geometry.h"

namespace hymm::core {
namespace {

Corners randomCorners(RandomGenerator& generator) {
  Corners corners;
  do {
    for (Eigen::Vector2d& corner : corners) {
      corner = {sampleUniform(generator, -20.0, 20.0), sampleUniform(generator, -20.0, 20.0)};
    }
  } while (turn(corners[0], corners[1], corners[2]) <= 0.0 || smallestAngle(corners) < 0.3);
  return corners;
}

/// Shortest length from the origin in direction `angle` by whole multiples of two steps between
/// which it lies, over the straight length.
double stretchAlong(const CellMetric& metric, const Triangle& triangle, int cells, double angle) {
  const Eigen::Vector2d straight =
      triangle.edgesInverse() * Eigen::Vector2d(std::cos(angle), std::sin(angle)) * cells;
  const std::vector<CellStep>& steps = metric.steps();
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const CellStep& u = steps[k];
    const CellStep& v = steps[(k + 1) % steps.size()];
    Eigen::Matrix2d both;
    both << u.di, v.di, u.dj, v.dj;
    const Eigen::Vector2d shares = both.inverse() * straight;
    if (shares.minCoeff() >= -1e-12) {
      return (shares.x() * u.length_m + shares.y() * v.length_m) / metric.length(straight);
    }
  }
  return std::numeric_limits<double>::infinity();
}

RC_GTEST_PROP(CellMetric, MeasuresLengthsInTheMap, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint64_t>());
  const Triangle triangle(randomCorners(generator));
  const CellMetric metric(triangle, 40, 70, 0.02);
  const Eigen::Vector2d cells(sampleUniform(generator, -9.0, 9.0),
                              sampleUniform(generator, -9.0, 9.0));
  const double length = (triangle.edges() * Eigen::Vector2d(cells.x() / 40, cells.y() / 70)).norm();
  RC_ASSERT(std::abs(metric.length(cells) - length) < 1e-9);
}

RC_GTEST_PROP(CellMetric, IsWorseThanStatedInNoDirection, ()) {
  RandomGenerator generator(*rc::gen::arbitrary<std::uint64_t>());
  const Triangle triangle(randomCorners(generator));
  const CellMetric metric(triangle, 50, 50, 0.02);
  RC_ASSERT(metric.error() < 0.02);
  double worst = 1.0;
  for (int i = 0; i < 2000; ++i) {
    worst = std::max(worst, stretchAlong(metric, triangle, 50, 2.0 * M_PI * i / 2000));
  }
  RC_ASSERT(worst < 1.0 + metric.error() + 1e-9);
  RC_ASSERT(worst > 1.0 + 0.99 * metric.error());
}

TEST(CellMetric, NeedsMoreThanSixteenDirectionsInSquareCells) {
  const Triangle square({Eigen::Vector2d(0, 0), Eigen::Vector2d(10, 0), Eigen::Vector2d(0, 10)});
  const CellMetric sixteen(square, 50, 50, 0.03);
  EXPECT_EQ(sixteen.steps().size(), 16U);
  EXPECT_NEAR(sixteen.error(), 0.0275, 1e-4);
  EXPECT_GT(CellMetric(square, 50, 50, 0.02).steps().size(), 16U);
}

TEST(CellMetric, ListsOppositeStepsHalfATurnApart) {
  const Triangle sheared({Eigen::Vector2d(0, 0), Eigen::Vector2d(9, 1), Eigen::Vector2d(7, 8)});
  const CellMetric metric(sheared, 30, 40, 0.02);
  const std::size_t half = metric.steps().size() / 2;
  for (std::size_t k = 0; k < half; ++k) {
    const CellStep& step = metric.steps()[k];
    const CellStep& back = metric.steps()[k + half];
    EXPECT_EQ(step.di, -back.di);
    EXPECT_EQ(step.dj, -back.dj);
  }
}

}  // namespace
}  // namespace hymm::core
