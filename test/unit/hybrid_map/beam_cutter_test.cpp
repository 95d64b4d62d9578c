#include "hybrid_map/beam_cutter.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hybrid_map/cell_traversal.h"
#include "hybrid_map/ltr_partition.h"
#include "hybrid_map/triangular_grid.h"
#include "landmark_maps.h"

namespace hymm::core {
namespace {

LtrPartition partitionOf(const LandmarkMap& map) {
  LtrPartition partition{PartitionConfig{}};
  partition.apply(map);
  return partition;
}

std::vector<BeamPiece> piecesOf(const LtrMesh& mesh, const Eigen::Vector2d& start,
                                const Eigen::Vector2d& end) {
  std::vector<BeamPiece> pieces;
  BeamCutter(mesh).cut(start, end, pieces);
  return pieces;
}

/// What is wrong with the pieces of a beam, or "".
std::string brokenPromise(const LtrMesh& mesh, const Eigen::Vector2d& start,
                          const Eigen::Vector2d& end) {
  double last = 0.0;
  for (const BeamPiece& piece : piecesOf(mesh, start, end)) {
    if (piece.from != last) return "there is a gap between pieces";
    if (piece.to < piece.from) return "a piece runs backwards";
    last = piece.to;
    // The middle of a piece tells where it lies: all in one LTR, which is convex, or outside.
    // Where a beam grazes a vertex, pieces begin and end to 1e-7 of its length.
    if (piece.to - piece.from < 1e-5) continue;
    for (const double share : {0.03, 0.5, 0.97}) {
      const double at = piece.from + share * (piece.to - piece.from);
      const Eigen::Vector2d place = start + at * (end - start);
      const Eigen::Vector2d told =
          piece.ltr == kNone ? piece.at(at) : mesh.ltr(piece.ltr).triangle.toGlobal(piece.at(at));
      if (!(told - place).isZero(1e-9)) return "a piece's own coordinates lie elsewhere";
      if (piece.ltr != kNone && !mesh.ltr(piece.ltr).triangle.contains(place)) {
        return "a piece leaves its LTR";
      }
      if (piece.ltr == kNone && mesh.locate(place) != kNone) {
        // Within a hair of a border both are right.
        const Triangle& triangle = mesh.ltr(mesh.locate(place)).triangle;
        const double depth = Triangle::weights(triangle.toLocal(place)).minCoeff();
        if (depth > 2e-6) return "a piece outside is inside";
      }
    }
  }
  return last == 1.0 ? "" : "the pieces do not reach the end";
}

TEST(BeamCutter, CutsABeamAtASharedSide) {
  const LtrPartition partition =
      partitionOf(mapOf({{0.0, 0.0}, {10.0, 0.0}, {5.0, 8.0}, {5.0, -8.0}}));
  const auto pieces = piecesOf(partition.mesh(), {5.0, 4.0}, {5.0, -6.0});
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_NEAR(pieces[0].to, 0.4, 1e-12);
  EXPECT_NE(pieces[0].ltr, pieces[1].ltr);
  EXPECT_EQ(brokenPromise(partition.mesh(), {5.0, 4.0}, {5.0, -6.0}), "");
}

TEST(BeamCutter, AppendsToWhatOtherBeamsLeft) {
  const LtrPartition partition = partitionOf(mapOf({{0.0, 0.0}, {10.0, 0.0}, {5.0, 8.0}}));
  BeamCutter cutter(partition.mesh());
  std::vector<BeamPiece> pieces;
  cutter.cut({5.0, 2.0}, {5.0, 3.0}, pieces);
  cutter.cut({5.0, 2.0}, {5.0, -3.0}, pieces);
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_EQ(pieces[0].to, 1.0);
  EXPECT_EQ(pieces[1].from, 0.0);
}

TEST(BeamCutter, CrossesAHoleBetweenTwoIslands) {
  const LtrPartition partition =
      partitionOf(mapOf({{0, 0}, {10, 0}, {5, 8}, {60, 0}, {70, 0}, {65, 8}}));
  ASSERT_EQ(partition.mesh().aliveCount(), 2U);
  const auto pieces = piecesOf(partition.mesh(), {-10.0, 2.0}, {90.0, 2.0});
  ASSERT_EQ(pieces.size(), 5U);
  EXPECT_EQ(pieces[0].ltr, kNone);
  EXPECT_EQ(pieces[2].ltr, kNone);
  EXPECT_EQ(pieces[4].ltr, kNone);
  EXPECT_NEAR(pieces[1].from, 0.1125, 1e-12);  // enters at x = 1.25
}

TEST(BeamCutter, CopesWithBeamsThroughVerticesAndAlongSides) {
  const LtrPartition partition = partitionOf(mapOf({{0.0, 0.0},
                                                    {10.0, 0.0},
                                                    {20.0, 0.0},
                                                    {0.0, 10.0},
                                                    {10.0, 10.0},
                                                    {20.0, 10.0},
                                                    {0.0, 20.0},
                                                    {10.0, 20.0},
                                                    {20.0, 20.0}}));
  const LtrMesh& mesh = partition.mesh();
  ASSERT_EQ(mesh.aliveCount(), 8U);
  const std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> beams = {
      {{-5.0, 10.0}, {25.0, 10.0}},  // along sides
      {{-5.0, -5.0}, {25.0, 25.0}},  // through vertices, along diagonals or across them
      {{-5.0, 25.0}, {25.0, -5.0}}, {{0.0, 0.0}, {20.0, 20.0}},
      {{10.0, 10.0}, {10.0, 10.0}},                              // of no length
      {{0.0, 0.0}, {20.0, 0.0}},                                 // along the border
      {{-5.0, 0.0}, {25.0, 0.0}},   {{-1.0, 1.0}, {1.0, -1.0}},  // touches a corner
      {{5.0, 3.0}, {10.0, 10.0}},                                // ends in a vertex
  };
  for (const auto& [start, end] : beams) {
    EXPECT_EQ(brokenPromise(mesh, start, end), "")
        << start.transpose() << " to " << end.transpose();
    EXPECT_EQ(brokenPromise(mesh, end, start), "")
        << end.transpose() << " to " << start.transpose();
  }
}

RC_GTEST_PROP(BeamCutter, PiecesFollowOneAnotherEachInItsLtr, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 40; ++i) places.emplace_back(uniform(0.0, 90.0), uniform(0.0, 90.0));
  const LtrPartition partition = partitionOf(mapOf(places));
  for (int i = 0; i < 100; ++i) {
    Eigen::Vector2d start(uniform(-20.0, 110.0), uniform(-20.0, 110.0));
    Eigen::Vector2d end(uniform(-20.0, 110.0), uniform(-20.0, 110.0));
    // Some beams go exactly from or to landmarks.
    if (uniform(0.0, 1.0) < 0.2) start = places[std::size_t(uniform(0.0, 39.99))];
    if (uniform(0.0, 1.0) < 0.2) end = places[std::size_t(uniform(0.0, 39.99))];
    const std::string broken = brokenPromise(partition.mesh(), start, end);
    RC_LOG() << broken << std::endl;
    RC_ASSERT(broken.empty());
  }
}

RC_GTEST_PROP(CellTraversal, PassesEveryCellThatALineTouches, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto point = [&] {
    return Eigen::Vector2d(sampleUniform(generator, -8.0, 8.0),
                           sampleUniform(generator, -8.0, 8.0));
  };
  const Eigen::Vector2d from = point(), to = point();
  std::vector<std::pair<int, int>> cells;
  const auto visit = [&](int i, int j) { cells.emplace_back(i, j); };
  traverseCells(from, to, visit);
  const auto cellOf = [](const Eigen::Vector2d& p) {
    return std::pair<int, int>(std::floor(p.x()), std::floor(p.y()));
  };
  RC_ASSERT(cells.front() == cellOf(from));
  RC_ASSERT(cells.back() == cellOf(to));
  const std::set<std::pair<int, int>> passed(cells.begin(), cells.end());
  RC_ASSERT(passed.size() == cells.size());
  for (std::size_t k = 1; k < cells.size(); ++k) {
    RC_ASSERT(std::abs(cells[k].first - cells[k - 1].first) +
                  std::abs(cells[k].second - cells[k - 1].second) ==
              1);
  }
  for (int k = 0; k <= 2000; ++k) {
    RC_ASSERT(passed.count(cellOf(from + k / 2000.0 * (to - from))) == 1);
  }
}

/// Lines from, to and through corners of cells, along rows and exact diagonals.
TEST(CellTraversal, StaysBetweenItsEndsWhereverCornersLie) {
  std::vector<Eigen::Vector2d> points;
  for (const double x : {-2.0, -1.5, -1.0, 0.0, 0.25, 1.0, 3.0}) {
    for (const double y : {-3.0, -1.0, -0.5, 0.0, 1.0, 2.5}) points.emplace_back(x, y);
  }
  for (const Eigen::Vector2d& from : points) {
    for (const Eigen::Vector2d& to : points) {
      const Eigen::Array2d first = from.array().floor(), last = to.array().floor();
      Eigen::Array2d at = first;
      int cells = 0;
      traverseCells(from, to, [&](int i, int j) {
        const Eigen::Array2d cell(i, j);
        EXPECT_EQ((cell - at).abs().sum(), cells == 0 ? 0.0 : 1.0);
        EXPECT_TRUE((cell >= first.min(last)).all() && (cell <= first.max(last)).all());
        at = cell;
        ++cells;
      });
      EXPECT_TRUE((at == last).all()) << from.transpose() << " to " << to.transpose();
      EXPECT_EQ(cells, (last - first).abs().sum() + 1.0);
    }
  }
}

/// The cells of its grid that lines pass, counted, and told by traverseCells().
RC_GTEST_PROP(TriangularGrid, ChangesEachCellOfALineOnceAndNoOther, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  const TriangularGrid grid(static_cast<int>(uniform(1.0, 60.0)),
                            static_cast<int>(uniform(1.0, 60.0)));
  const auto place = [&] {
    const double alpha = uniform(0.0, 0.999), beta = uniform(0.0, 0.999 - alpha);
    return Triangle::Local(alpha, beta);
  };
  const Triangle::Local from = place(), to = place();
  std::vector<float> expected(std::size_t(grid.cellCount()), 0.0F), cells = expected;
  traverseCells(grid.toCells(from), grid.toCells(to),
                [&](int i, int j) { expected[std::size_t(grid.index(i, j))] += 1.0F; });
  const int count =
      grid.changeAlong(from, to, cells.data(), [](float before) { return before + 1.0F; });
  RC_ASSERT(cells == expected);
  RC_ASSERT(count == static_cast<int>(std::count(cells.begin(), cells.end(), 1.0F)));
}

TEST(TriangularGrid, KeepsLinesAlongItsThirdSideInside) {
  for (const auto& [alpha_cells, beta_cells] :
       {std::pair(1, 1), std::pair(7, 7), std::pair(150, 1), std::pair(3, 90)}) {
    const TriangularGrid grid(alpha_cells, beta_cells);
    std::vector<float> cells(std::size_t(grid.cellCount()) + 1, 0.0F);
    const auto count = [](float before) { return before + 1.0F; };
    grid.changeAlong({1.0, 0.0}, {0.0, 1.0}, cells.data(), count);
    grid.changeAlong({0.0, 1.0}, {1.0, 0.0}, cells.data(), count);
    EXPECT_EQ(cells.back(), 0.0F);  // one past the grid
    for (int j = 0; j < beta_cells; ++j) {
      EXPECT_EQ(cells[std::size_t(grid.index(grid.rowLength(j) - 1, j))], 2.0F)
          << alpha_cells << " x " << beta_cells << ", row " << j;
    }
  }
}

RC_GTEST_PROP(TriangularGrid, HasACellForEveryPointOfTheTriangleAndNoOther, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  const Triangle triangle({Eigen::Vector2d(0, 0), Eigen::Vector2d(uniform(0.1, 9.0), 0.0),
                           Eigen::Vector2d(uniform(-2.0, 2.0), uniform(0.5, 9.0))});
  const TriangularGrid grid(triangle, uniform(0.05, 3.0));
  std::map<int, std::pair<int, int>> cell_of_index;
  int sum = 0;
  for (int j = 0; j < grid.betaCells(); ++j) {
    sum += grid.rowLength(j);
    // The last cell of a row still touches the inside.
    RC_ASSERT((grid.rowLength(j) - 1.0) / grid.alphaCells() + double(j) / grid.betaCells() < 1.0);
  }
  RC_ASSERT(sum == grid.cellCount());
  for (int k = 0; k < 300; ++k) {
    const double alpha = uniform(0.0, 1.0), beta = uniform(0.0, 1.0 - alpha);
    const Triangle::Local cells = grid.toCells({alpha, beta});
    const std::pair<int, int> cell(std::floor(cells.x()), std::floor(cells.y()));
    RC_ASSERT(cell.first < grid.rowLength(cell.second));
    const int index = grid.index(Triangle::Local(alpha, beta));
    RC_ASSERT(index >= 0 && index < grid.cellCount());
    RC_ASSERT(cell_of_index.emplace(index, cell).first->second == cell);
  }
}

}  // namespace
}  // namespace hymm::core
