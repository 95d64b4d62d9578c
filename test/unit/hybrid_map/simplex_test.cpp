#include "hybrid_map/simplex.h"

#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/random.h"

namespace hymm::core {
namespace {

template <class SimplexType>
class AnySimplex : public testing::Test {
 public:
  using Point = typename SimplexType::Point;
  using Local = typename SimplexType::Local;
  using Corners = std::array<Point, std::size_t(SimplexType::kLocal) + 1>;

  Point randomPoint(double extent) {
    return Point::NullaryExpr([&](auto) { return sampleUniform(generator_, -extent, extent); });
  }

  Corners randomCorners() {
    Corners corners;
    do {
      for (Point& corner : corners) corner = randomPoint(30.0);
    } while (std::abs(SimplexType(corners).measure()) < 20.0);
    return corners;
  }

  Local randomLocal() {
    return Local::NullaryExpr([&](auto) { return sampleUniform(generator_, -1.0, 2.0); });
  }

  RandomGenerator generator_{7};
};

using AllKinds = testing::Types<Triangle, TerrainTriangle, Tetrahedron>;

class KindName {
 public:
  template <class SimplexType>
  static std::string GetName(int) {  // NOLINT(readability-identifier-naming): GoogleTest's name
    if (std::is_same_v<SimplexType, Triangle>) return "Triangle";
    return std::is_same_v<SimplexType, TerrainTriangle> ? "TerrainTriangle" : "Tetrahedron";
  }
};
TYPED_TEST_SUITE(AnySimplex, AllKinds, KindName);

TYPED_TEST(AnySimplex, LocalCoordinatesComeBackFromTheGlobalPlace) {
  for (int i = 0; i < 200; ++i) {
    const TypeParam simplex(this->randomCorners());
    const auto local = this->randomLocal();
    EXPECT_LT((simplex.toLocal(simplex.toGlobal(local)) - local).norm(), 1e-11);
  }
}

TYPED_TEST(AnySimplex, VerticesAreTheCornersOfTheLocalCoordinates) {
  const auto corners = this->randomCorners();
  const TypeParam simplex(corners);
  for (int i = 0; i <= TypeParam::kLocal; ++i) {
    const auto weights = TypeParam::weights(simplex.toLocal(corners[std::size_t(i)]));
    EXPECT_LT((weights - TypeParam::Weights::Unit(i)).norm(), 1e-12) << "vertex " << i;  // (5)
    EXPECT_LT((simplex.vertex(i) - corners[std::size_t(i)]).norm(), 1e-12);
  }
}

TYPED_TEST(AnySimplex, ContainsItsBordersAndNothingBeyond) {
  const auto corners = this->randomCorners();
  const TypeParam simplex(corners);
  typename TypeParam::Point centre = TypeParam::Point::Zero();
  for (const auto& corner : corners) {
    EXPECT_TRUE(simplex.contains(corner));
    centre += corner / double(corners.size());
  }
  EXPECT_TRUE(simplex.contains(centre));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto& next = corners[(i + 1) % corners.size()];
    EXPECT_TRUE(simplex.contains(typename TypeParam::Point(0.3 * corners[i] + 0.7 * next)));
    const typename TypeParam::Point beyond = centre + 1.001 * (corners[i] - centre);
    EXPECT_FALSE(simplex.contains(beyond));
  }
}

TYPED_TEST(AnySimplex, PointsFollowTheirVertices) {
  for (int i = 0; i < 50; ++i) {
    const auto corners = this->randomCorners();
    auto shifts = corners;
    auto moved = corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      shifts[k] = this->randomPoint(2.0);
      moved[k] = corners[k] + shifts[k];
    }
    const auto local = this->randomLocal();
    const typename TypeParam::Point difference =
        TypeParam(moved).toGlobal(local) - TypeParam(corners).toGlobal(local);
    EXPECT_LT((TypeParam::displacement(local, shifts) - difference).norm(), 1e-12);  // (6)
  }
}

TYPED_TEST(AnySimplex, PointNearAVertexThatStandsStillHardlyMoves) {
  auto shifts = this->randomCorners();
  shifts[0].setZero();
  const typename TypeParam::Local near = TypeParam::Local::Constant(1e-4);
  EXPECT_LT(TypeParam::displacement(near, shifts).norm(), 1e-4 * 3 * 60.0);  // (5), (6)
}

TYPED_TEST(AnySimplex, WithoutExtentContainsNothing) {
  typename TestFixture::Corners corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = TypeParam::Point::Constant(double(i));  // all on one line
  }
  const TypeParam simplex(corners);
  EXPECT_EQ(simplex.measure(), 0.0);
  EXPECT_FALSE(simplex.contains(corners[1]));
}

TYPED_TEST(AnySimplex, DoesNotContainWhatIsNotFinite) {
  const TypeParam simplex(this->randomCorners());
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(simplex.contains(typename TypeParam::Point(TypeParam::Point::Constant(kNan))));
}

TEST(Triangle, MeasureIsItsSignedArea) {
  const Eigen::Vector2d a(1.0, 1.0), b(5.0, 1.0), c(1.0, 4.0);
  EXPECT_DOUBLE_EQ(Triangle({a, b, c}).measure(), 6.0);
  EXPECT_DOUBLE_EQ(Triangle({a, c, b}).measure(), -6.0);
}

TEST(Tetrahedron, MeasureIsItsVolume) {
  const Eigen::Vector3d o(1.0, 2.0, 3.0);
  const Tetrahedron corner({o, o + 2.0 * Eigen::Vector3d::UnitX(),
                            o + 3.0 * Eigen::Vector3d::UnitY(),
                            o + 4.0 * Eigen::Vector3d::UnitZ()});
  EXPECT_NEAR(corner.measure(), 4.0, 1e-14);
}

TEST(TerrainTriangle, TellsHeightAboveItsPlane) {
  const Eigen::Vector3d a(0.0, 0.0, 1.0), b(4.0, 0.0, 4.0), c(0.0, 2.0, 1.0);
  const TerrainTriangle slope({a, b, c});
  EXPECT_NEAR(slope.measure(), 5.0, 1e-14);
  const Eigen::Vector3d normal(-0.6, 0.0, 0.8);
  const Eigen::Vector3d point = slope.toGlobal({0.25, 0.5}) + 0.7 * normal;
  EXPECT_NEAR(slope.height(point), 0.7, 1e-14);
  EXPECT_LT((slope.toLocal(point) - Eigen::Vector2d(0.25, 0.5)).norm(), 1e-14);
}

RC_GTEST_PROP(Triangle, KeepsLocalCoordinatesOfWhatMovesWithIt, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double extent) { return sampleUniform(generator, -extent, extent); };
  const Eigen::Vector2d shift(uniform(1e4), uniform(1e4));
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(uniform(3.1)).toRotationMatrix();
  std::array<Eigen::Vector2d, 3> corners, moved;
  for (int i = 0; i < 3; ++i) {
    corners[std::size_t(i)] = {uniform(30.0), uniform(30.0)};
    moved[std::size_t(i)] = turn * corners[std::size_t(i)] + shift;
  }
  RC_PRE(std::abs(Triangle(corners).measure()) > 5.0);
  const Eigen::Vector2d point(uniform(30.0), uniform(30.0));
  const Eigen::Vector2d before = Triangle(corners).toLocal(point);
  const Eigen::Vector2d after = Triangle(moved).toLocal(turn * point + shift);
  RC_ASSERT((before - after).norm() < 1e-9);
}

}  // namespace
}  // namespace hymm::core
