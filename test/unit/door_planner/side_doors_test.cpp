#include "door_planner/side_doors.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "support/planner_meshes.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
constexpr double kWidth_m = 1.9;
constexpr double kSpacing_m = 4.0;

/// The two LTRs of a square of 16 m, which share its falling diagonal; places on it run from
/// landmark 1, at (16, 0), to landmark 2, at (0, 16).
struct Pair {
  test::SquareMesh mesh{1, 1, 16.0, 0.2};

  CellCosts costs(std::size_t ltr, const std::function<float(const Vector2d&)>& occupancy) const {
    const LtrView& view = mesh.ltrs[ltr];
    return {{}, {}, gridOf(view.alpha_cells, view.beta_cells), test::contentOf(view, occupancy)};
  }
  SideDoors doors(const std::function<float(const Vector2d&)>& lower,
                  const std::function<float(const Vector2d&)>& upper,
                  const std::vector<std::pair<double, double>>& solid = {}) const {
    const CellCosts first = costs(0, lower), second = costs(1, upper);
    return findDoors({mesh.ltrs[0], 1, first}, {mesh.ltrs[1], 1, second}, solid, kWidth_m,
                     kSpacing_m);
  }
};

float freeGround(const Vector2d&) { return 0.0F; }

/// Free where the height over the ground lies within [low, high].
auto gap(double low, double high) {
  return [=](const Vector2d& p) { return p.y() < low || p.y() > high ? 1.0F : 0.0F; };
}

TEST(SideDoors, AreNarrowerWhereALandmarkStands) {
  const Pair pair;
  // Of 22.6 m: what is left beside it is wider than the vehicle on one side only.
  const SideDoors found = pair.doors(freeGround, freeGround, {{0.05, 0.3}});
  ASSERT_EQ(found.doors.size(), 1U);
  EXPECT_NEAR(found.doors[0].from, 0.3, 0.01);
  EXPECT_NEAR(found.doors[0].to, 1.0, 1e-12);
}

TEST(SideDoors, ShareTheirPlacesBetweenBothLtrs) {
  const Pair pair;
  for (const double at : {0.0, 0.3, 1.0}) {
    const Vector2d lower =
        Triangle(pair.mesh.ltrs[0].corners).toGlobal(placeOnSide(pair.mesh.ltrs[0], 1, at));
    const Vector2d upper =
        Triangle(pair.mesh.ltrs[1].corners).toGlobal(placeOnSide(pair.mesh.ltrs[1], 1, at));
    EXPECT_TRUE(lower.isApprox(upper, 1e-12));
    EXPECT_TRUE(lower.isApprox(Vector2d(16.0 * (1.0 - at), 16.0 * at), 1e-12));
  }
}

TEST(SideDoors, SplitAFreeSideIntoPortalsAtMostFourMetresApart) {
  const SideDoors doors = Pair().doors(freeGround, freeGround);
  ASSERT_EQ(doors.doors.size(), 1U);
  const double length_m = 16.0 * std::sqrt(2.0);
  ASSERT_GE(doors.portals.size(), 5U);
  EXPECT_LE(doors.portals.front() * length_m, 2.0 + 1e-9);
  EXPECT_LE((1.0 - doors.portals.back()) * length_m, 2.0 + 1e-9);
  for (std::size_t i = 1; i < doors.portals.size(); ++i) {
    EXPECT_LE((doors.portals[i] - doors.portals[i - 1]) * length_m, kSpacing_m + 1e-9);
  }
}

TEST(SideDoors, NeedTheWidthOfTheVehicle) {
  // On the diagonal, 1 m of height is 1.41 m of the side.
  EXPECT_TRUE(Pair().doors(gap(5.0, 6.0), gap(5.0, 6.0)).doors.empty());
  EXPECT_EQ(Pair().doors(gap(5.0, 6.6), gap(5.0, 6.6)).doors.size(), 1U);
}

TEST(SideDoors, NeedMoreWidthWhereTheShapeIsUncertain) {
  Pair pair;
  EXPECT_EQ(pair.doors(gap(5.0, 6.6), gap(5.0, 6.6)).doors.size(), 1U);
  pair.mesh.ltrs[1].shape_factor = 1.3;
  EXPECT_TRUE(pair.doors(gap(5.0, 6.6), gap(5.0, 6.6)).doors.empty());
}

TEST(SideDoors, MustBeSeenFreeFromBothSides) {
  EXPECT_TRUE(Pair().doors(gap(2.0, 6.0), gap(7.0, 12.0)).doors.empty());
  EXPECT_EQ(Pair().doors(gap(2.0, 9.0), gap(5.0, 12.0)).doors.size(), 1U);
}

TEST(SideDoors, KeepTheirIdsWhileTheirBordersMove) {
  const Pair pair;
  const auto two_gaps = [](double shift) {
    return [shift](const Vector2d& p) {
      const bool low = p.y() > 2.0 + shift && p.y()<5.0 + shift, high = p.y()> 9.0 && p.y() < 14.0;
      return low || high ? 0.0F : 1.0F;
    };
  };
  std::uint64_t next_id = 1;
  SideDoors first = pair.doors(two_gaps(0.0), two_gaps(0.0));
  keepIds({}, first, next_id);
  ASSERT_EQ(first.doors.size(), 2U);
  SideDoors second = pair.doors(two_gaps(1.0), two_gaps(1.0));
  keepIds(first, second, next_id);
  EXPECT_EQ(second.doors[0].id, first.doors[0].id);
  EXPECT_EQ(second.doors[1].id, first.doors[1].id);
  SideDoors third = pair.doors(gap(9.0, 14.0), gap(9.0, 14.0));
  keepIds(second, third, next_id);
  ASSERT_EQ(third.doors.size(), 1U);
  EXPECT_EQ(third.doors[0].id, first.doors[1].id);
}

}  // namespace
}  // namespace hymm::core
