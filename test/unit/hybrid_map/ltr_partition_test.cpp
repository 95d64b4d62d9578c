#include "hybrid_map/ltr_partition.h"

#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "landmark_maps.h"
#include "partition_invariants.h"

namespace hymm::core {
namespace {

double area(const LtrMesh& mesh) {
  double sum = 0.0;
  for (const int ltr : aliveLtrs(mesh)) sum += mesh.ltr(ltr).triangle.measure();
  return sum;
}

const std::vector<Eigen::Vector2d> kSquare = {{0.0, 0.0}, {10.0, 0.0}, {11.0, 9.0}, {0.0, 10.0}};

TEST(LtrPartition, CutsFourLandmarksIntoTwoLtrsThatShareASide) {
  const LandmarkMap map = mapOf(kSquare);
  const LtrPartition partition = partitionOf(map);
  EXPECT_EQ(partition.mesh().aliveCount(), 2U);
  EXPECT_EQ(brokenInvariant(partition, map), "");
  EXPECT_EQ(partition.pinnedLandmarks(), (std::vector<int>{0, 1, 2, 3}));
}

TEST(LtrPartition, CoversTheHullOfLandmarksThatLieWell) {
  RandomGenerator generator(3);
  const LandmarkMap map = jitteredGrid(12, 8, 10.0, generator);
  const LtrPartition partition = partitionOf(map);
  EXPECT_EQ(brokenInvariant(partition, map), "");
  EXPECT_GT(area(partition.mesh()), 0.93 * 110.0 * 70.0);
}

TEST(LtrPartition, CoversLandmarksThatStandCloserThanItsSidesMayBe) {
  for (const double spacing_m : {0.55, 0.7, 1.0, 1.5, 2.0}) {
    RandomGenerator generator(11);
    const int edge = static_cast<int>(20.0 / spacing_m);
    const LandmarkMap map = jitteredGrid(edge, edge, spacing_m, generator);
    const LtrPartition partition = partitionOf(map);
    EXPECT_EQ(brokenInvariant(partition, map), "");
    // A border as wide as half of the shortest side need not be covered.
    const double covered_m = (edge - 1) * spacing_m - PartitionConfig().min_side_m;
    EXPECT_GT(area(partition.mesh()), covered_m * covered_m) << spacing_m;
  }
}

TEST(LtrPartition, CoversADenseStandThatComesToBeKnownByAndBy) {
  RandomGenerator generator(12);
  const LandmarkMap all = jitteredGrid(20, 20, 1.0, generator);
  LtrPartition partition{PartitionConfig{}};
  LandmarkMap known = all;
  for (double front_m = 3.0; front_m < 23.0; front_m += 1.5) {
    known = LandmarkMap{};
    known.version = all.version;
    for (const LandmarkEstimate& landmark : all.landmarks) {
      if (landmark.position.x() < front_m) known.landmarks.push_back(landmark);
    }
    correlate(known);
    partition.apply(known);
    ASSERT_EQ(brokenInvariant(partition, known), "");
  }
  EXPECT_GT(area(partition.mesh()), 17.0 * 17.0);
}

TEST(LtrPartition, MakesDelaunayTrianglesOfLandmarksThatComeAtOnce) {
  RandomGenerator generator(4);
  const LandmarkMap map = jitteredGrid(8, 8, 10.0, generator);
  const LtrPartition partition = partitionOf(map);
  const LtrMesh& mesh = partition.mesh();
  int with_landmark_in_circle = 0;
  for (const int ltr : aliveLtrs(mesh)) {
    for (const auto& landmark : map.landmarks) {
      if (landmarksOf(mesh, ltr).count(landmark.id) > 0) continue;
      if (isInsideCircumcircle(mesh.corners(ltr), landmark.position)) {
        ++with_landmark_in_circle;
        break;
      }
    }
  }
  EXPECT_LE(with_landmark_in_circle, static_cast<int>(mesh.aliveCount()) / 20);
}

TEST(LtrPartition, MakesNothingOfCollinearLandmarks) {
  const LandmarkMap map = mapOf({{0.0, 0.0}, {5.0, 5.0}, {10.0, 10.0}});
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 0U);
}

TEST(LtrPartition, MakesNothingOfLandmarksAtOnePlace) {
  const LandmarkMap map = mapOf({{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}, {9.0, 1.0}});
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 0U);
}

TEST(LtrPartition, WaitsUntilLandmarksAreWellObserved) {
  LandmarkMap map = mapOf(kSquare);
  map.landmarks[2].observations = 1;
  LtrPartition partition = partitionOf(map);
  EXPECT_EQ(partition.mesh().aliveCount(), 1U);
  map.landmarks[2].observations = 20;
  EXPECT_EQ(partition.apply(map).created.size(), 1U);
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, WaitsUntilTheShapeIsCertain) {
  LandmarkMap map = mapOf({{0.0, 0.0}, {10.0, 0.0}, {0.0, 10.0}});
  for (auto& landmark : map.landmarks) landmark.covariance = 9.0 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 0U);
  // As uncertain each, but together: the shape is known.
  for (auto& pair : map.cross_covariances) pair.block = 8.999 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 1U);
}

TEST(LtrPartition, TakesCovariancesThatAreNotToldForUnknown) {
  LandmarkMap map = mapOf({{0.0, 0.0}, {10.0, 0.0}, {0.0, 10.0}});
  map.cross_covariances.pop_back();
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 0U);
}

TEST(LtrPartition, HoldsToItsBoundsOnSides) {
  EXPECT_EQ(partitionOf(mapOf({{0.0, 0.0}, {31.0, 0.0}, {15.0, 20.0}})).mesh().aliveCount(), 0U);
  EXPECT_EQ(partitionOf(mapOf({{0.0, 0.0}, {1.5, 0.0}, {0.7, 1.5}})).mesh().aliveCount(), 0U);
}

TEST(LtrPartition, FillsAGapWithAThinLtrButMakesNoneElsewhere) {
  // The first three are too flat on their own; between two others they fill the gap.
  LandmarkMap map = mapOf({{0.0, 0.0}, {10.0, 1.5}, {20.0, 0.0}});
  EXPECT_EQ(partitionOf(map).mesh().aliveCount(), 0U);
  map = mapOf({{0.0, 0.0}, {10.0, 1.5}, {20.0, 0.0}, {4.0, 12.0}, {16.0, 12.0}});
  const LtrPartition partition = partitionOf(map);
  EXPECT_EQ(brokenInvariant(partition, map), "");
  EXPECT_NE(partition.mesh().locate({10.0, 1.0}), kNone);
}

TEST(LtrPartition, GrowsOutsideAndLeavesOutLandmarksInside) {
  LandmarkMap map = mapOf({{0.0, 0.0}, {12.0, 0.0}, {6.0, 11.0}});
  LtrPartition partition = partitionOf(map);
  map = mapOf({{0.0, 0.0}, {12.0, 0.0}, {6.0, 11.0}, {6.0, 4.0}, {17.0, 10.0}});
  const PartitionChange change = partition.apply(map);
  EXPECT_TRUE(change.retired.empty());
  ASSERT_EQ(change.created.size(), 1U);
  EXPECT_EQ(landmarksOf(partition.mesh(), change.created[0]), (std::set<int>{1, 2, 4}));
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, KeepsIdentityThroughTurnAndShift) {
  RandomGenerator generator(5);
  LandmarkMap map = jitteredGrid(6, 5, 10.0, generator);
  LtrPartition partition = partitionOf(map);
  const std::vector<int> before = aliveLtrs(partition.mesh());
  const Pose2 correction{40.0, -30.0, 1.0};
  for (auto& landmark : map.landmarks) landmark.position = correction * landmark.position;
  const PartitionChange change = partition.apply(map);
  EXPECT_TRUE(change.retired.empty());
  EXPECT_EQ(aliveLtrs(partition.mesh()), before);
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, RetiresAnLtrThatTurnsOver) {
  LandmarkMap map = mapOf({{0.0, 0.0}, {10.0, 0.0}, {5.0, 8.0}});
  LtrPartition partition = partitionOf(map);
  map.landmarks[2].position.y() = -8.0;
  const PartitionChange change = partition.apply(map);
  ASSERT_EQ(change.retired.size(), 1U);
  EXPECT_EQ(change.retired[0].reason, RetiredLtr::Reason::kShape);
  EXPECT_EQ(change.retired[0].last_valid.measure(), 40.0);
  EXPECT_EQ(change.created.size(), 1U);  // the same landmarks, in the other order
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, OfTwoThatOverlapTheOneWithFewerObservationsGoes) {
  for (const int richer : {0, 1}) {
    LandmarkMap map = mapOf({{0, 0}, {10, 0}, {5, 8}, {40, 0}, {50, 0}, {45, 8}});
    LtrPartition partition = partitionOf(map);
    ASSERT_EQ(partition.mesh().aliveCount(), 2U);
    partition.addObservations(richer, 10.0);
    partition.addObservations(1 - richer, 9.0);
    for (int i = 3; i < 6; ++i) map.landmarks[std::size_t(i)].position.x() -= 38.0;
    const PartitionChange change = partition.apply(map);
    ASSERT_EQ(change.retired.size(), 1U);
    EXPECT_EQ(change.retired[0].ltr, 1 - richer);
    EXPECT_EQ(change.retired[0].reason, RetiredLtr::Reason::kOverlap);
    EXPECT_EQ(brokenInvariant(partition, map), "");
  }
}

TEST(LtrPartition, FindsAnIslandThatASlideBroughtInsideAnother) {
  // The border of the small island comes to lie among inner LTRs of the large one.
  RandomGenerator generator(6);
  LandmarkMap map = jitteredGrid(9, 9, 10.0, generator);
  const Eigen::Vector2d far(300.0, 0.0);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(3, 0), Eigen::Vector2d(0, 3)}) {
    map.landmarks.push_back(landmarkAt(static_cast<int>(map.landmarks.size()), corner + far));
  }
  correlate(map);
  LtrPartition partition = partitionOf(map);
  const int island = partition.mesh().locate(far + Eigen::Vector2d(1, 1));
  ASSERT_NE(island, kNone);
  for (std::size_t i = 81; i < 84; ++i) {
    map.landmarks[i].position += Eigen::Vector2d(42.0, 43.0) - far;
  }
  const PartitionChange change = partition.apply(map);
  ASSERT_FALSE(change.retired.empty());
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, LosesItsLtrsWhenAllLandmarksAreRemoved) {
  LandmarkMap map = mapOf(kSquare);
  LtrPartition partition = partitionOf(map);
  map.landmarks.clear();
  map.cross_covariances.clear();
  const PartitionChange change = partition.apply(map);
  EXPECT_EQ(change.retired.size(), 2U);
  EXPECT_EQ(change.retired[0].reason, RetiredLtr::Reason::kVertexGone);
  EXPECT_EQ(brokenInvariant(partition, map), "");
  EXPECT_TRUE(partition.pinnedLandmarks().empty());
}

TEST(LtrPartition, RenamesTheVertexOfAMergedLandmark) {
  LandmarkMap map = mapOf(kSquare);
  LtrPartition partition = partitionOf(map);
  const std::vector<int> before = aliveLtrs(partition.mesh());
  map.landmarks[0].id = 9;
  std::rotate(map.landmarks.begin(), map.landmarks.begin() + 1, map.landmarks.end());
  map.landmarks.back().position += Eigen::Vector2d(0.2, 0.1);
  map.merges = {{0, 7}, {7, 9}};
  correlate(map);
  const PartitionChange change = partition.apply(map);
  EXPECT_TRUE(change.retired.empty());
  EXPECT_EQ(aliveLtrs(partition.mesh()), before);
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, RetiresAnLtrWhoseVerticesBecomeOneLandmark) {
  LandmarkMap map = mapOf(kSquare);
  LtrPartition partition = partitionOf(map);
  map.landmarks.erase(map.landmarks.begin());
  map.merges = {{0, 1}};
  correlate(map);
  partition.apply(map);
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, AnUpdateCorrectsWhatItTells) {
  LandmarkMap map = mapOf(kSquare);
  LtrPartition partition = partitionOf(map);
  LandmarkUpdate update;
  map.landmarks[2].position += Eigen::Vector2d(0.5, -0.5);
  update.changed = {map.landmarks[2]};
  EXPECT_TRUE(partition.apply(update).retired.empty());
  EXPECT_EQ(brokenInvariant(partition, map), "");
  update.changed.clear();
  update.removed_ids = {2, 12345};
  map.landmarks.erase(map.landmarks.begin() + 2);
  EXPECT_EQ(partition.apply(update).retired.size(), partition.mesh().aliveCount() == 0 ? 2U : 1U);
  EXPECT_EQ(brokenInvariant(partition, map), "");
}

TEST(LtrPartition, LocatesPointsAsAComparisonWithEveryLtrDoes) {
  RandomGenerator generator(8);
  const LandmarkMap map = jitteredGrid(10, 10, 12.0, generator);
  const LtrPartition partition = partitionOf(map);
  const LtrMesh& mesh = partition.mesh();
  int hint = kNone;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector2d point(sampleUniform(generator, -20.0, 140.0),
                                sampleUniform(generator, -20.0, 140.0));
    bool is_anywhere = false;
    for (const int ltr : aliveLtrs(mesh)) {
      is_anywhere = is_anywhere || mesh.ltr(ltr).triangle.contains(point);
    }
    const int found = mesh.locate(point, hint);
    ASSERT_EQ(found != kNone, is_anywhere);
    if (found == kNone) continue;
    ASSERT_TRUE(mesh.ltr(found).triangle.contains(point));
    hint = found;
  }
}

/// Lives through a random history and checks every promise after each step.
RC_GTEST_PROP(LtrPartition, StaysValidWhateverTheLandmarksDo, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  const auto uniform = [&](double low, double high) { return sampleUniform(generator, low, high); };
  LtrPartition partition{PartitionConfig{}};
  LandmarkMap map;
  int next_id = 0;
  for (int step = 0; step < 14; ++step) {
    const int fresh = static_cast<int>(uniform(0.0, 12.0));
    for (int i = 0; i < fresh; ++i) {
      map.landmarks.push_back(landmarkAt(next_id++, {uniform(0.0, 80.0), uniform(0.0, 60.0)}));
      map.landmarks.back().observations = static_cast<int>(uniform(1.0, 20.0));
    }
    // From tiny corrections to ones that turn everything over.
    const double size = std::pow(10.0, uniform(-3.0, 1.7));
    for (auto& landmark : map.landmarks) {
      if (uniform(0.0, 1.0) < 0.3) continue;
      landmark.position += Eigen::Vector2d(uniform(-size, size), uniform(-size, size));
      landmark.observations += 2;
    }
    if (!map.landmarks.empty() && uniform(0.0, 1.0) < 0.4) {
      const auto gone = map.landmarks.begin() +
                        std::ptrdiff_t(uniform(0.0, 0.999) * double(map.landmarks.size()));
      const auto into = map.landmarks.begin() +
                        std::ptrdiff_t(uniform(0.0, 0.999) * double(map.landmarks.size()));
      if (uniform(0.0, 1.0) < 0.5 && gone->id != into->id)
        map.merges.push_back({gone->id, into->id});
      map.landmarks.erase(gone);
    }
    correlate(map);
    std::map<int, std::set<int>> before;
    for (const int ltr : aliveLtrs(partition.mesh())) {
      before[ltr] = landmarksOf(partition.mesh(), ltr);
      if (uniform(0.0, 1.0) < 0.5) partition.addObservations(ltr, uniform(0.0, 100.0));
    }
    const PartitionChange change = partition.apply(map);
    const std::string broken = brokenInvariant(partition, map);
    RC_LOG() << "step " << step << ": " << broken << std::endl;
    RC_ASSERT(broken.empty());
    std::set<int> retired;
    for (const RetiredLtr& r : change.retired) RC_ASSERT(retired.insert(r.ltr).second);
    for (const auto& [ltr, landmarks] : before) {
      RC_ASSERT(partition.mesh().ltr(ltr).is_alive == (retired.count(ltr) == 0));
    }
    const LtrMesh& mesh = partition.mesh();
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d point(uniform(-20.0, 100.0), uniform(-20.0, 80.0));
      int inside = 0;
      for (const int ltr : aliveLtrs(mesh)) inside += mesh.ltr(ltr).triangle.contains(point);
      RC_ASSERT((mesh.locate(point, i % (mesh.ltrEnd() + 1)) != kNone) == (inside > 0));
    }
  }
}

// An open strip of LTRs around a ring whose last part slides over its first.
TEST(LtrPartition, ClosingStripLosesTheOverlapsAndOnlyThose) {
  std::vector<Eigen::Vector2d> open, closed;
  constexpr int kPairs = 43;
  for (int i = 0; i < kPairs; ++i) {
    for (const double radius : {60.0, 68.0}) {
      const double share = double(i) / kPairs;
      open.push_back(Eigen::Rotation2Dd(5.6 * share) * Eigen::Vector2d(radius, 0.0));
      closed.push_back(Eigen::Rotation2Dd(7.0 * share) * Eigen::Vector2d(radius, 0.0));
    }
  }
  LandmarkMap map = mapOf(open);
  LtrPartition partition = partitionOf(map);
  ASSERT_EQ(partition.mesh().aliveCount(), 84U);
  for (std::size_t i = 0; i < closed.size(); ++i) map.landmarks[i].position = closed[i];
  const PartitionChange change = partition.apply(map);
  EXPECT_EQ(brokenInvariant(partition, map), "");
  // 0.72 rad overlap, of 7: about a tenth of the strip, and a neighbour or two at each end.
  EXPECT_GE(change.retired.size(), 8U);
  EXPECT_LE(change.retired.size(), 14U);
  for (const RetiredLtr& r : change.retired) EXPECT_EQ(r.reason, RetiredLtr::Reason::kOverlap);
}

}  // namespace
}  // namespace hymm::core
