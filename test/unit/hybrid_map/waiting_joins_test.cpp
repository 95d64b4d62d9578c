/// How what sheets hold of the same places comes together.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "hybrid_map/log_odds.h"
#include "hybrid_map/waiting_tiles.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

/// A map without LTRs over two pairs of landmarks, 40 m apart.
struct TwoSheets {
  TwoSheets() : map(withoutLtrs()) { map.apply(landmarks); }

  static HybridMapConfig withoutLtrs() {
    HybridMapConfig config = withLayers();
    config.partition.min_observations = 1000;
    return config;
  }
  void tellAgain() {
    ++landmarks.version;
    ASSERT_TRUE(map.apply(landmarks).accepted);
  }
  /// From between the landmarks of one pair, a beam towards the other.
  void lookRight() { map.insert(beam({6.0, 5.0, 0.0}, 22.0, landmarks.version)); }
  void lookLeft() { map.insert(beam({46.0, 5.0, M_PI}, 22.0, landmarks.version)); }

  /// Sheets that know the occupancy of a place.
  int sheetsAt(const Eigen::Vector2d& place) const {
    int count = 0;
    map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
      const Eigen::Array2i cell =
          ((inverse(tile.T_map_cells) * place) / tile.resolution_m).array().floor().cast<int>();
      if ((cell < 0).any() || (cell >= WaitingTile::kCells).any()) return;
      const int index = cell.y() * WaitingTile::kCells + cell.x();
      if (*tile.cells->read(map.layers(), LayerSet::kOccupancy, index) != 0.0F) ++count;
    });
    return count;
  }

  /// The largest probability of being occupied that any sheet knows within a cell of a place.
  double most(const Eigen::Vector2d& place) const {
    double most = 0.0;
    const double reach_m = map.resolution_m();
    map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
      for (int index = 0; index < WaitingTile::kCells * WaitingTile::kCells; ++index) {
        const Eigen::Vector2d cell(index % WaitingTile::kCells + 0.5,
                                   index / WaitingTile::kCells + 0.5);
        const Eigen::Vector2d off = tile.T_map_cells * (tile.resolution_m * cell) - place;
        const float* log_odds = tile.cells->read(map.layers(), LayerSet::kOccupancy, index);
        if (off.cwiseAbs().maxCoeff() > reach_m || *log_odds == 0.0F) continue;
        most = std::max(most, probabilityOf(static_cast<double>(*log_odds)));
      }
    });
    return most;
  }

  LandmarkMap landmarks = mapOf({{0.0, 0.0}, {12.0, 0.0}, {40.0, 0.0}, {52.0, 0.0}});
  HybridMap map;
};

TEST(HybridMap, WhatTwoSheetsSawOfOnePlaceComesTogether) {
  TwoSheets two;
  two.lookRight();
  two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  // Both saw from x = 24 m to x = 28 m; halfway lies x = 26 m.
  ASSERT_EQ(two.sheetsAt({24.9, 5.0}), 2);
  ASSERT_EQ(two.sheetsAt({27.1, 5.0}), 2);
  const double before = two.map.evidenceWaiting(0);
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_EQ(two.sheetsAt({27.1, 5.0}), 1);
  EXPECT_EQ(two.sheetsAt({26.0, 5.0}), 2);  // the seam
  EXPECT_NEAR(two.map.evidenceWaiting(0), before, 1e-4);
}

TEST(HybridMap, AnObstacleSeenLaterInAnotherSheetStandsAsInOneGrid) {
  // At first there is nothing at x = 24.9 m, as the sheet on the left knows. Then, seen from the
  // right, there is.
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_GT(two.most({24.9, 5.0}), 0.9);
}

TEST(HybridMap, OneHitWhereItWasSurelyFreeIsInDoubtAsInOneGrid) {
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  ASSERT_GT(two.most({24.9, 5.0}), 0.9);
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_LT(two.most({24.9, 5.0}), 0.5);
}

TEST(HybridMap, WhatWasHitOftenAndThenMissedStandsAsInOneGrid) {
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  for (int scan = 0; scan < 4; ++scan) two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_GT(two.most({24.9, 5.0}), 0.8);
}

TEST(HybridMap, AMapThatWasSavedKnowsWhatWasHitOftenAndThenMissed) {
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  for (int scan = 0; scan < 4; ++scan) two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.map.loadState(two.map.saveState(), "map", two.landmarks.version);
  two.tellAgain();
  EXPECT_GT(two.most({24.9, 5.0}), 0.8);
}

TEST(HybridMap, WhatIsWrittenAfterTwoSheetsWereJoinedIsJoinedToo) {
  TwoSheets two;
  two.lookRight();
  two.lookLeft();
  const auto leave = [&] {
    two.map.insert(beam({100.0, 100.0, 0.0}, 2.0, two.landmarks.version));
    two.tellAgain();
  };
  leave();
  ASSERT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  for (int scan = 0; scan < 10; ++scan) {
    two.map.insert(beam({46.0, 5.0, M_PI}, 21.1, two.landmarks.version));
  }
  ASSERT_EQ(two.sheetsAt({24.9, 5.0}), 2);
  leave();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_GT(two.most({24.9, 5.0}), 0.9);
}

TEST(HybridMap, SheetsWhoseAnchorsTurnOutToBeTheSameComeTogether) {
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, 0.0}, 12.1));
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.landmarks.landmarks.resize(2);
  correlate(two.landmarks);
  two.landmarks.merges = {{2, 0}, {3, 1}};
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({10.0, 5.0}), 1);
  EXPECT_EQ(two.sheetsAt({18.1, 5.0}), 1);
  EXPECT_GT(two.most({18.1, 5.0}), 0.9);
}

TEST(HybridMap, AnObstacleThatIsNoMoreThereInALaterSheetIsForgotten) {
  TwoSheets two;
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_LT(two.most({24.9, 5.0}), 0.1);
}

TEST(HybridMap, WhatASheetSawLongAgoIsNotLaterBecauseItIsWrittenAgainBeside) {
  // As above; then the sheet on the left is written again, in the same tiles, but a metre aside.
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  for (int scan = 0; scan < 5; ++scan) two.map.insert(beam({6.0, 4.0, 0.0}, 22.0));
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_GT(two.most({24.9, 5.0}), 0.9);
}

TEST(HybridMap, AMapThatWasSavedKnowsWhatWasSeenLater) {
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 10; ++scan) two.map.insert(beam({46.0, 5.0, M_PI}, 21.1));
  for (int scan = 0; scan < 5; ++scan) two.map.insert(beam({6.0, 4.0, 0.0}, 22.0));
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.map.loadState(two.map.saveState(), "map", two.landmarks.version);
  two.tellAgain();
  EXPECT_GT(two.most({24.9, 5.0}), 0.9);
}

/// Two landmarks at the bottom and two at the top, which an LTR comes to join. Before that, from
/// either pair's sheet, the place in between was seen.
struct TwoSheetsUnderAnLtr {
  TwoSheetsUnderAnLtr() {
    for (const std::size_t i : {2U, 3U}) landmarks.landmarks[i].observations = 1;
    map.apply(landmarks);
  }
  /// From the bottom nothing is seen there, from the top there is something.
  void lookUp(double x = 6.0) { map.insert(beam({x, 5.0, M_PI / 2.0}, 12.0)); }
  void lookDown() { map.insert(beam({6.0, 38.0, -M_PI / 2.0}, 28.1)); }
  void grow() {
    ++landmarks.version;
    landmarks.landmarks[2].observations = 50;
    ASSERT_EQ(map.apply(landmarks).change.created.size(), 1U);
  }
  double most() const {
    double most = 0.0;
    for (double x = -0.2; x <= 0.2; x += 0.05) {
      for (double y = -0.2; y <= 0.2; y += 0.05) {
        most = std::max(most, probabilityAt(map, Eigen::Vector2d(6.0 + x, 9.9 + y)));
      }
    }
    return most;
  }

  LandmarkMap landmarks = mapOf({{0.0, 0.0}, {12.0, 0.0}, {6.0, 24.0}, {16.0, 40.0}});
  HybridMap map{withLayers()};
};

TEST(HybridMap, AnObstacleSeenLaterStandsInTheLtrThatTakesSeveralSheets) {
  TwoSheetsUnderAnLtr two;
  for (int scan = 0; scan < 50; ++scan) two.lookUp();
  for (int scan = 0; scan < 10; ++scan) two.lookDown();
  two.grow();
  EXPECT_GT(two.most(), 0.9);
}

TEST(HybridMap, AnObstacleThatIsNoMoreThereIsForgottenInTheLtrThatTakesSeveralSheets) {
  TwoSheetsUnderAnLtr two;
  for (int scan = 0; scan < 10; ++scan) two.lookDown();
  for (int scan = 0; scan < 50; ++scan) {
    for (double x = 5.0; x <= 7.0; x += 0.1) two.lookUp(x);
  }
  two.grow();
  EXPECT_LT(two.most(), 0.35);
}

TEST(HybridMap, WhatComesTogetherFromManySheetsCanBeRelearned) {
  // Both sheets know for certain that there is nothing; together they are no more certain.
  TwoSheets two;
  for (int scan = 0; scan < 50; ++scan) two.lookRight();
  for (int scan = 0; scan < 50; ++scan) two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  ASSERT_EQ(two.sheetsAt({24.9, 5.0}), 1);
  EXPECT_NEAR(two.most({24.9, 5.0}), 0.03, 1e-4);
}

TEST(HybridMap, SheetsThatAreNotCertainOfEachOtherStayApart) {
  TwoSheets two;
  two.landmarks.cross_covariances.pop_back();  // of 40 m and 52 m
  for (auto& pair : two.landmarks.cross_covariances) pair.block *= 0.0;
  for (auto& landmark : two.landmarks.landmarks) landmark.covariance *= 4.0;
  two.lookRight();
  two.lookLeft();
  two.map.insert(beam({100.0, 100.0, 0.0}, 2.0));
  two.tellAgain();
  EXPECT_EQ(two.sheetsAt({24.9, 5.0}), 2);
}

}  // namespace
}  // namespace hymm::core
