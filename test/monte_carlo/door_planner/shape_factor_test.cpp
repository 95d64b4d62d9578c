// How often a path is dearer than K times its cost says, with the vertices of the LTRs that it
// crosses drawn from their joint covariance: single entries of cost matrices, and whole routes. The
// same with factors that are wrong shows that the tests would find these.

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "common/random.h"
#include "door_planner/door_search.h"
#include "door_planner/side_bounds.h"
#include "support/planner_worlds.h"

namespace hymm::core {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using Covariance = Eigen::Matrix<double, 6, 6>;
/// A rule for K by the corners of an LTR and their joint covariance.
using Rule = std::function<double(const Corners&, const Covariance&)>;

constexpr int kDraws = 20000;
constexpr double kBeyondThreeSigma = 0.00135;  // of a normal distribution, on one side
/// Four deviations of a count of that mean.
const double kAllowed = kBeyondThreeSigma + 4.0 * std::sqrt(kBeyondThreeSigma / kDraws);

double withoutTheThree(const Corners& corners, const Covariance& covariance) {
  return 1.0 + (shapeFactor(corners, covariance) - 1.0) / 3.0;
}

/// That what is wrong is wrong beyond doubt.
void expectFound(const std::string& rule, double share) {
  EXPECT_GT(share, 10.0 * kAllowed) << rule;
  testing::Test::RecordProperty(rule, std::to_string(share));
}

/// Landmarks of a mesh, what of them is uncertain, and the ground between them.
struct UncertainMesh {
  test::SquareMesh mesh{3, 3, 12.0, 0.4, 2.0, 3};
  MatrixXd covariance;  ///< of all landmarks together
  DoorPlanner planner{config()};

  /// Ways between places near the border, whose costs are all that counts here.
  static DoorPlannerConfig config() {
    DoorPlannerConfig made;
    made.outside_is_occupied = false;
    return made;
  }

  explicit UncertainMesh(std::uint64_t seed)
      : mesh(3, 3, 12.0, 0.4, 2.0, seed),
        covariance(MatrixXd::Zero(2 * Eigen::Index(mesh.landmarks.size()),
                                  2 * Eigen::Index(mesh.landmarks.size()))) {
    const test::Occupancy obstacles = test::discs(seed, 8, 36.0, {{2.0, 2.0}, {34.0, 34.0}});
    planner.setLtrs(mesh.ltrs);
    for (const LtrView& ltr : mesh.ltrs) {
      planner.setContent(ltr.id, test::contentOf(ltr, [&](const Vector2d& p) {
                           const bool is_rough = std::sin(0.5 * p.x() + p.y()) > 0.6;
                           return std::max(obstacles(p), is_rough ? 0.5F : 0.0F);
                         }));
    }
  }

  /// All of them may lie elsewhere, by metres.
  void addShift() {
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      for (Eigen::Index j = i % 2; j < covariance.cols(); j += 2) covariance(i, j) += 4.0;
    }
  }
  /// Each on its own, in a direction of its own.
  void addNoise(double sigma_m, RandomGenerator& generator) {
    for (Eigen::Index k = 0; k < covariance.rows(); k += 2) {
      const Eigen::Matrix2d root = Eigen::Matrix2d::NullaryExpr(
          [&](auto, auto) { return sampleNormal(generator, sigma_m); });
      covariance.block<2, 2>(k, k) += root * root.transpose();
    }
  }
  /// All distances grow or shrink by the same share, as with a speed that is told wrongly.
  void addScale(double share) {
    const VectorXd all = VectorXd::NullaryExpr(covariance.rows(), [&](Eigen::Index i) {
      return share * mesh.landmarks[std::size_t(i / 2)][i % 2];
    });
    covariance += all * all.transpose();
  }

  void useFactors(const Rule& rule) {
    for (LtrView& ltr : mesh.ltrs) {
      Covariance own;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          own.block<2, 2>(2 * i, 2 * j) = covariance.block<2, 2>(
              2 * ltr.landmark_ids[std::size_t(i)], 2 * ltr.landmark_ids[std::size_t(j)]);
        }
      }
      ltr.shape_factor = rule(ltr.corners, own);
    }
    planner.setLtrs(mesh.ltrs);
    planner.prepare(Vector2d::Zero());
  }

  /// As many places of the landmarks as there are draws.
  std::vector<test::Landmarks> draw(RandomGenerator& generator) const {
    const MatrixXd root = covariance.llt().matrixL();
    std::vector<test::Landmarks> draws(kDraws, mesh.landmarks);
    for (test::Landmarks& landmarks : draws) {
      const VectorXd shift = root * VectorXd::NullaryExpr(covariance.rows(), [&](auto) {
                               return sampleNormal(generator, 1.0);
                             });
      for (std::size_t i = 0; i < landmarks.size(); ++i) {
        landmarks[i] += shift.segment<2>(2 * Eigen::Index(i));
      }
    }
    return draws;
  }
};

/// A straight piece of a path inside an LTR: where it leads by the landmarks, and what a metre of
/// it costs in the mean.
struct Piece {
  std::array<int, 3> landmark_ids;
  Eigen::Vector3d weights;  ///< of the landmarks: those of its end less those of its beginning
  double per_metre;

  Piece(const GraphLtr& ltr, const Triangle::Local& from, const Triangle::Local& to)
      : landmark_ids(ltr.view.landmark_ids),
        weights(Triangle::weights(to) - Triangle::weights(from)),
        per_metre(ltr.costs->integrate(from, to, 1.0)) {}

  double costAmong(const test::Landmarks& landmarks) const {
    Vector2d along = Vector2d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      along += weights[Eigen::Index(k)] * landmarks[std::size_t(landmark_ids[k])];
    }
    return per_metre * along.norm();
  }
};
using Path = std::vector<Piece>;

/// Share of the draws in which a path, which keeps its local coordinates, costs more than `told`.
double shareDearer(const Path& path, double told, const std::vector<test::Landmarks>& draws) {
  const auto dearer = std::count_if(draws.begin(), draws.end(), [&](const auto& landmarks) {
    double cost = 0.0;
    for (const Piece& piece : path) cost += piece.costAmong(landmarks);
    return cost > told;
  });
  return static_cast<double>(dearer) / static_cast<double>(draws.size());
}

/// The largest share over the entries of the matrix of an LTR.
double largestShareOfEntries(const DoorGraph& graph, int number,
                             const std::vector<test::Landmarks>& draws) {
  const GraphLtr& ltr = graph.ltr(number);
  double largest = 0.0;
  for (int from = 0; from < ltr.matrix->size(); ++from) {
    for (int to = from + 1; to < ltr.matrix->size(); to += 3) {
      const auto cost = static_cast<double>(ltr.matrix->cost(from, to));
      if (cost == kNoPassing || cost == 0.0) continue;
      const std::vector<Triangle::Local> way =
          graph.wayBetween(number, graph.portalAt(number, from), graph.portalAt(number, to));
      Path path;
      for (std::size_t i = 1; i < way.size(); ++i) path.emplace_back(ltr, way[i - 1], way[i]);
      largest = std::max(largest, shareDearer(path, ltr.factor * cost, draws));
    }
  }
  return largest;
}

/// The largest share over entries of matrices in meshes whose vertices are uncertain by
/// centimetres against each other and by metres together.
double largestShareOfEntries(const Rule& rule) {
  double largest = 0.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    RandomGenerator generator(seed);
    UncertainMesh uncertain(seed);
    uncertain.addShift();
    uncertain.addNoise(0.05, generator);
    uncertain.useFactors(rule);
    const std::vector<test::Landmarks> draws = uncertain.draw(generator);
    // Four LTRs around the middle, with neighbours on all sides.
    for (int number = 7; number <= 10; ++number) {
      largest = std::max(largest, largestShareOfEntries(*uncertain.planner.graph(), number, draws));
    }
  }
  return largest;
}

TEST(CostMatrix, IsTooCheapNoMoreOftenThanThreeSigmaSay) {
  const double share = largestShareOfEntries(shapeFactor);
  EXPECT_LE(share, kAllowed);
  // Nor is K larger than it must be: in the worst direction there is as much as is allowed.
  EXPECT_GE(share, 0.3 * kBeyondThreeSigma);
  RecordProperty("share", std::to_string(share));
}

TEST(CostMatrix, WouldBeFoundTooCheapWithAnotherFactor) {
  expectFound("one sigma", largestShareOfEntries(withoutTheThree));
  expectFound("(16)", largestShareOfEntries(sideVectorBound));
  expectFound("(17)", largestShareOfEntries(sideLengthBound));
}

/// The largest share over routes across meshes, in which all LTRs may be too small together.
double largestShareOfRoutes(const Rule& rule) {
  double largest = 0.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomGenerator generator(seed);
    UncertainMesh uncertain(seed);
    uncertain.addShift();
    uncertain.addNoise(0.001, generator);
    uncertain.addScale(0.01);
    uncertain.useFactors(rule);
    const std::shared_ptr<const DoorGraph> graph = uncertain.planner.graph();
    const auto placeAt = [&](const Vector2d& point) {
      const int ltr = graph->locate(point);
      return GraphPlace{ltr, graph->ltr(ltr).triangle.toLocal(point)};
    };
    DoorRoute route;
    EXPECT_EQ(DoorSearch().find(*graph, placeAt({2.5, 2.5}), placeAt({33.0, 33.0}), {}, route),
              SearchOutcome::kFound);
    Path path;
    for (std::size_t i = 1; i < route.waypoints.size(); ++i) {
      const GraphPlace& to = route.waypoints[i].place;
      const GraphPlace& before = route.waypoints[i - 1].place;
      const GraphLtr& ltr = graph->ltr(to.ltr);
      const Vector2d from = graph->ltr(before.ltr).triangle.toGlobal(before.local);
      path.emplace_back(ltr, ltr.triangle.toLocal(from), to.local);
    }
    EXPECT_GT(route.portals.size(), 4U);
    largest = std::max(largest, shareDearer(path, route.cost, uncertain.draw(generator)));
  }
  return largest;
}

TEST(DoorRoute, IsTooCheapNoMoreOftenThanThreeSigmaSay) {
  const double share = largestShareOfRoutes(shapeFactor);
  EXPECT_LE(share, kAllowed);
  RecordProperty("share", std::to_string(share));
}

TEST(DoorRoute, WouldBeFoundTooCheapWithAnotherFactor) {
  expectFound("one sigma", largestShareOfRoutes(withoutTheThree));
  expectFound("(16)", largestShareOfRoutes(sideVectorBound));
  expectFound("(17)", largestShareOfRoutes(sideLengthBound));
}

TEST(SideLengthBound, IsNeverAboveThatOfTheSidesVectors) {
  RandomGenerator generator(11);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    UncertainMesh uncertain(seed);
    uncertain.addNoise(0.05, generator);
    uncertain.useFactors([](const Corners& corners, const Covariance& covariance) {
      EXPECT_LE(sideLengthBound(corners, covariance), sideVectorBound(corners, covariance));
      return 1.0;
    });
  }
}

}  // namespace
}  // namespace hymm::core
