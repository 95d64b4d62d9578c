#include "hybrid_map/cell_overlay.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace hymm::core {
namespace {

constexpr float kLimit = 3.5F;
constexpr int kOccupancy = LayerSet::kOccupancy;

/// Three cells, of which is known when they were seen.
struct Cells {
  explicit Cells(CellStore::Seen seen = CellStore::Seen::kCells) : store(layers, 3, seen) {}

  void write(int cell, float log_odds, std::uint64_t revision) {
    store.write(layers, kOccupancy, revision)[cell] = log_odds;
    if (auto* seen = store.seenCells(kOccupancy)) seen[cell] = static_cast<std::uint32_t>(revision);
  }
  float read(int cell) const { return *store.read(layers, kOccupancy, cell); }

  std::vector<std::string> problems;
  LayerSet layers{"", 1, problems, {-kLimit, kLimit}};
  CellStore store;
};

/// A cell that is laid over another.
struct Laid {
  float log_odds;
  std::uint64_t seen;
  bool has_left_limit = false;
};

/// Lays a grid of cells (parts of them, if a share is told) over the first cell of another.
void lay(const std::vector<Laid>& cells, float share, Cells& over) {
  CellOverlay overlay(over.layers, 100);
  std::vector<CellPart> parts;
  for (const Laid& cell : cells) {
    const bool was_at_limit = cell.has_left_limit || std::abs(cell.log_odds) >= kLimit;
    parts.push_back({kOccupancy, &cell.log_odds, share, cell.seen, 1, was_at_limit});
  }
  for (const CellPart& part : parts) overlay.makeRoom(part, {&over.store, 0});
  for (const CellPart& part : parts) overlay.add(part, {&over.store, 0});
  overlay.finish();
}

TEST(CellOverlay, WhatWasSeenLaterStandsWhicheverMoves) {
  Cells later_moves, earlier_moves;
  later_moves.write(0, -kLimit, 1);
  lay({{kLimit, 2}}, 1.0F, later_moves);
  EXPECT_FLOAT_EQ(later_moves.read(0), kLimit);
  earlier_moves.write(0, kLimit, 2);
  lay({{-kLimit, 1}}, 1.0F, earlier_moves);
  EXPECT_FLOAT_EQ(earlier_moves.read(0), kLimit);
}

TEST(CellOverlay, OneHitAddsUpWithWhatWasKnownBefore) {
  // In one grid, too, one hit leaves what was surely free in doubt.
  constexpr float kHit = 2.9F;
  Cells later_moves, earlier_moves;
  later_moves.write(0, -kLimit, 1);
  lay({{kHit, 2}}, 1.0F, later_moves);
  EXPECT_FLOAT_EQ(later_moves.read(0), kHit - kLimit);
  earlier_moves.write(0, kHit, 2);
  lay({{-kLimit, 1}}, 1.0F, earlier_moves);
  EXPECT_FLOAT_EQ(earlier_moves.read(0), kHit - kLimit);
}

TEST(CellOverlay, WhatWasAtALimitDoesNotDependOnWhatWasKnownBefore) {
  // Many hits, then misses: the last grid knows for certain that something stands there, and how
  // often it was missed since.
  Cells later_moves, earlier_moves;
  later_moves.write(0, -kLimit, 1);
  lay({{1.5F, 2, true}}, 1.0F, later_moves);
  EXPECT_FLOAT_EQ(later_moves.read(0), 1.5F);
  earlier_moves.write(0, 1.5F, 2);
  earlier_moves.store.noteLimit(kOccupancy, 0);
  lay({{-kLimit, 1}}, 1.0F, earlier_moves);
  EXPECT_FLOAT_EQ(earlier_moves.read(0), 1.5F);
}

TEST(CellOverlay, PartsThatWereAtALimitTogetherMakeForgetAllThatWasKnown) {
  Cells cells;
  cells.write(0, kLimit, 1);
  lay({{-kLimit, 2}, {-kLimit, 2}, {-kLimit, 2}}, 1.0F / 3.0F, cells);
  EXPECT_FLOAT_EQ(cells.read(0), -kLimit);
}

TEST(CellOverlay, ACellToWhichSuchPartsCameIsLikeThem) {
  Cells cells;
  lay({{1.5F, 2, true}}, 1.0F, cells);
  EXPECT_TRUE(cells.store.wasAtLimit(cells.layers, kOccupancy, 0));
  lay({{-kLimit, 1}}, 1.0F, cells);
  EXPECT_FLOAT_EQ(cells.read(0), 1.5F);
}

TEST(CellOverlay, WhatWasSurelyFreeKnowsThatWhenAHitWasLaidOverIt) {
  // What a third grid saw before either does not matter then, as it would not in one grid.
  constexpr float kHit = 2.9F;
  for (const float first : {-kLimit, kLimit}) {
    Cells cells;
    cells.write(0, -kLimit, 5);
    lay({{kHit, 10}}, 1.0F, cells);
    EXPECT_TRUE(cells.store.wasAtLimit(cells.layers, kOccupancy, 0));
    lay({{first, 1}}, 1.0F, cells);
    EXPECT_FLOAT_EQ(cells.read(0), kHit - kLimit) << first;
  }
}

TEST(CellOverlay, ACellWhoseEvidenceWentElsewhereBeginsAnew) {
  Cells cells;
  cells.write(0, 1.5F, 2);
  cells.store.noteLimit(kOccupancy, 0);
  cells.store.keep(cells.layers, kOccupancy, 0, 0.0F);
  cells.write(0, 1.0F, 3);
  EXPECT_FALSE(cells.store.wasAtLimit(cells.layers, kOccupancy, 0));
  cells.write(1, -kLimit, 4);
  cells.store.keep(cells.layers, kOccupancy, 1, 0.5F);
  EXPECT_TRUE(cells.store.wasAtLimit(cells.layers, kOccupancy, 1));
}

TEST(CellOverlay, ACellWhoseEvidenceWentElsewhereMeanwhileBeginsAnew) {
  // As when two grids are laid over each other, each on its side.
  Cells cells;
  cells.write(0, -kLimit, 5);
  CellOverlay overlay(cells.layers, 100);
  const float hit = 2.9F;
  overlay.add({kOccupancy, &hit, 1.0F, 6, 1, false}, {&cells.store, 1});
  cells.store.keep(cells.layers, kOccupancy, 0, 0.0F);
  overlay.finish();
  EXPECT_FALSE(cells.store.wasAtLimit(cells.layers, kOccupancy, 0));
  lay({{-1.0F, 1}}, 1.0F, cells);
  EXPECT_FLOAT_EQ(cells.read(0), -1.0F);
  EXPECT_EQ(cells.store.seen(kOccupancy, 0), 1U);
}

TEST(CellOverlay, WhetherACellWasAtALimitIsKnownWhenItWasPacked) {
  Cells cells;
  cells.write(0, 1.5F, 2);
  cells.store.noteLimit(kOccupancy, 0);
  cells.store.pack(3);
  EXPECT_TRUE(cells.store.wasAtLimit(cells.layers, kOccupancy, 0));
  EXPECT_FALSE(cells.store.wasAtLimit(cells.layers, kOccupancy, 1));
}

TEST(CellOverlay, OfTheSameTimeNeitherIsForgotten) {
  Cells cells;
  cells.write(0, -kLimit, 2);
  lay({{kLimit, 2}}, 1.0F, cells);
  EXPECT_FLOAT_EQ(cells.read(0), 0.0F);
}

TEST(CellOverlay, PartsThatComeTogetherDoNotMakeEachOtherForget) {
  // Whatever comes first of them, and although the cell was never seen.
  Cells one, other;
  lay({{-3.0F, 1}, {1.0F, 2}}, 1.0F, one);
  lay({{1.0F, 2}, {-3.0F, 1}}, 1.0F, other);
  EXPECT_FLOAT_EQ(one.read(0), -2.0F);
  EXPECT_FLOAT_EQ(other.read(0), -2.0F);
}

TEST(CellOverlay, ACellIsAsLateAsTheLatestThatCameToIt) {
  Cells cells;
  cells.write(0, -1.0F, 5);
  cells.write(1, -1.0F, 3);
  lay({{-1.0F, 4}, {-1.0F, 9}}, 0.5F, cells);
  EXPECT_EQ(cells.store.seen(kOccupancy, 0), 9U);
  EXPECT_EQ(cells.store.seen(kOccupancy, 1), 3U);
  EXPECT_EQ(cells.store.revision(kOccupancy), 100U);  // for those who draw it
}

TEST(CellOverlay, APackedRegionKnowsWhenItWasSeenAsAWhole) {
  Cells cells;
  cells.write(0, -1.0F, 3);
  cells.write(1, -1.0F, 5);
  cells.store.pack(6);
  EXPECT_EQ(cells.store.seen(kOccupancy, 0), 5U);
  EXPECT_FLOAT_EQ(cells.read(0), -1.0F);
  EXPECT_EQ(cells.store.seen(kOccupancy, 0), 5U);
  EXPECT_EQ(cells.store.seen(kOccupancy), 5U);
}

/// Grids that lie over one another say the same in whichever order they are laid.
RC_GTEST_PROP(CellOverlay, DoesNotDependOnTheOrderOfTwoGrids, ()) {
  const auto log_odds = [] { return static_cast<float>(*rc::gen::inRange(-35, 36)) / 10.0F; };
  const float first = log_odds(), second = log_odds();
  const auto first_left = *rc::gen::arbitrary<bool>(), second_left = *rc::gen::arbitrary<bool>();
  const auto seen = *rc::gen::inRange<std::uint64_t>(1, 4);
  const auto kind =
      *rc::gen::arbitrary<bool>() ? CellStore::Seen::kCells : CellStore::Seen::kLayers;
  Cells one(kind), other(kind);
  lay({{first, seen, first_left}}, 1.0F, one);
  lay({{second, 2, second_left}}, 1.0F, one);
  lay({{second, 2, second_left}}, 1.0F, other);
  lay({{first, seen, first_left}}, 1.0F, other);
  RC_ASSERT(std::abs(one.read(0) - other.read(0)) < 1e-5F);
  const auto wasAtLimit = [](const Cells& cells) {
    return cells.store.wasAtLimit(cells.layers, kOccupancy, 0);
  };
  RC_ASSERT(one.read(0) == 0.0F || wasAtLimit(one) == wasAtLimit(other));
}

}  // namespace
}  // namespace hymm::core
