#include "hybrid_map/map_image.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "common/error.h"
#include "hybrid_map/log_odds.h"
#include "random_history.h"
#include "small_maps.h"

namespace hymm::core {
namespace {

/// A scan of one beam, seen often enough that what it meets is certain.
void insertBeam(HybridMap& map, const Pose2& T_map_laser, double range_m) {
  const PosedScan posed = beam(T_map_laser, range_m, map.landmarkVersion());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(map.insert(posed).accepted);
}

MapImageConfig exactly() {
  MapImageConfig config;
  config.redraw_shift_cells = 0.0;
  return config;
}

std::int8_t percentAt(const OccupancyImage& image, const Eigen::Vector2d& place) {
  const Eigen::Array2i cell =
      (place / image.resolution_m).array().floor().cast<int>() - image.corner.array();
  if ((cell < 0).any() || cell.x() >= image.width || cell.y() >= image.height) return -1;
  return image.at(cell.x(), cell.y());
}

/// Within one cell.
std::int8_t greatestAround(const OccupancyImage& image, const Eigen::Vector2d& place) {
  std::int8_t greatest = OccupancyImage::kUnknown;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const Eigen::Vector2d off(x, y);
      greatest = std::max(greatest, percentAt(image, place + image.resolution_m * off));
    }
  }
  return greatest;
}

int cellsOf(const ImageChange& change) {
  int cells = 0;
  for (const ImagePatch& patch : change.patches) cells += patch.width * patch.height;
  return cells;
}

/// Whether two images show the same, wherever their corners are.
bool showTheSame(const OccupancyImage& a, const OccupancyImage& b) {
  const auto isShownBy = [](const OccupancyImage& shown, const OccupancyImage& by) {
    for (int y = 0; y < shown.height; ++y) {
      for (int x = 0; x < shown.width; ++x) {
        if (shown.at(x, y) != percentAt(by, shown.centre(x, y))) return false;
      }
    }
    return true;
  };
  return isShownBy(a, b) && isShownBy(b, a);
}

TEST(OccupancyPercent, RoundsTheProbability) {
  EXPECT_EQ(occupancyPercent(0.0F), -1);
  for (int percent = 0; percent <= 100; ++percent) {
    for (const double off : {-0.0049, 0.0001, 0.0049}) {
      const double probability = percent / 100.0 + off;
      if (probability <= 0.0 || probability >= 1.0) continue;
      EXPECT_EQ(occupancyPercent(static_cast<float>(logOddsOf(probability))), percent);
    }
  }
  EXPECT_EQ(occupancyPercent(100.0F), 100);
  EXPECT_EQ(occupancyPercent(-100.0F), 0);
}

TEST(MapImage, IsEmptyUntilSomethingIsKnown) {
  MapImage image(exactly());
  EXPECT_TRUE(image.update(mapOver(squareMap())).isEmpty());
  EXPECT_TRUE(image.image().cells.empty());
}

TEST(MapImage, ShowsABeamInsideAndOutsideOfLtrs) {
  HybridMap map = mapOver(squareMap());
  insertBeam(map, {5.05, 0.05, 0.0}, 10.1);  // the LTRs end at 10 m
  MapImage image(exactly());
  EXPECT_TRUE(image.update(map).is_resized);
  EXPECT_EQ(percentAt(image.image(), {15.1, 0.1}), 97);
  EXPECT_EQ(percentAt(image.image(), {12.1, 0.1}), 3);
  EXPECT_EQ(percentAt(image.image(), {8.1, 0.1}), 3);
  EXPECT_EQ(percentAt(image.image(), {8.1, 2.1}), -1);
}

TEST(MapImage, LeavesOutWhatWaitsIfToldSo) {
  HybridMap map = mapOver(squareMap());
  insertBeam(map, {5.05, 0.05, 0.0}, 10.1);
  MapImageConfig config = exactly();
  config.include_waiting = false;
  MapImage image(config);
  image.update(map);
  EXPECT_EQ(percentAt(image.image(), {15.1, 0.1}), -1);
  EXPECT_EQ(percentAt(image.image(), {8.1, 0.1}), 3);
}

TEST(MapImage, DrawsOnlyWhereSomethingWasWritten) {
  RandomGenerator generator(3);
  HybridMap map = mapOver(jitteredGrid(12, 12, 15.0, generator));
  for (double x = 5.0; x < 165.0; x += 10.0) {
    for (double y = 5.0; y < 165.0; y += 10.0) insertBeam(map, {x, y, 0.7}, 9.0);
  }
  MapImage image(exactly());
  image.update(map);
  EXPECT_TRUE(image.update(map).isEmpty());
  const OccupancyImage before = image.image();
  insertBeam(map, {40.0, 40.0, 2.5}, 4.0);
  const ImageChange change = image.update(map);
  EXPECT_FALSE(change.is_resized);
  EXPECT_GT(cellsOf(change), 0);
  // A beam of 20 cells crosses two tiles of 32 at most in each direction.
  EXPECT_LE(cellsOf(change), 4 * ImageTiles::kCells * ImageTiles::kCells);
  EXPECT_FALSE(showTheSame(before, image.image()));
}

TEST(MapImage, MovesWithTheLandmarks) {
  LandmarkMap landmarks = squareMap();
  HybridMap map = mapOver(landmarks);
  insertBeam(map, {-5.0, 0.05, 0.0}, 9.05);
  MapImage image(exactly());
  image.update(map);
  const Pose2 correction{7.0, -6.0, 0.8};
  for (auto& landmark : landmarks.landmarks) landmark.position = correction * landmark.position;
  ++landmarks.version;
  ASSERT_TRUE(map.apply(landmarks).accepted);
  image.update(map);
  EXPECT_EQ(greatestAround(image.image(), correction * Eigen::Vector2d(4.05, 0.05)), 97);
  EXPECT_EQ(greatestAround(image.image(), {4.05, 0.05}), -1);
}

TEST(MapImage, WaitsWithDrawingUntilAShiftIsWorthIt) {
  LandmarkMap landmarks = squareMap();
  HybridMap map = mapOver(landmarks);
  insertBeam(map, {-5.0, 0.05, 0.0}, 9.05);
  MapImageConfig config;
  config.redraw_shift_cells = 0.5;
  MapImage image(config);
  image.update(map);
  const auto shift = [&](double metres) {
    for (auto& landmark : landmarks.landmarks) landmark.position.x() += metres;
    ++landmarks.version;
    ASSERT_TRUE(map.apply(landmarks).accepted);
  };
  shift(0.06);
  EXPECT_TRUE(image.update(map).isEmpty());
  shift(0.06);  // together more than half a cell
  EXPECT_FALSE(image.update(map).isEmpty());
}

TEST(MapImage, ForgetsWhatAResetForgot) {
  HybridMap map = mapOver(squareMap());
  insertBeam(map, {-5.0, 0.05, 0.0}, 9.05);
  MapImage image(exactly());
  image.update(map);
  map.reset();
  ASSERT_TRUE(map.apply(squareMap()).accepted);
  image.update(map);
  EXPECT_THAT(image.image().cells, testing::Each(OccupancyImage::kUnknown));
}

TEST(MapImage, LeavesPackedLtrsPacked) {
  HybridMap map = mapOver(squareMap());
  insertBeam(map, {-5.0, 0.05, 0.0}, 9.05);
  for (int i = 0; i < 30; ++i) insertBeam(map, {200.0 + 6.0 * i, 0.0, 0.0}, 5.0);
  const std::size_t packed = map.ltrMemory().packed_bytes;
  ASSERT_GT(packed, 0U);
  MapImage image(exactly());
  image.update(map);
  EXPECT_EQ(percentAt(image.image(), {4.0, 0.05}), 97);
  EXPECT_EQ(map.ltrMemory().packed_bytes, packed);
}

TEST(MapImage, IsCutOffWhereItWouldNeedMoreMemoryThanAllowed) {
  HybridMap map = mapOver(squareMap());
  insertBeam(map, {-5.0, 0.05, 0.0}, 9.05);
  MapImageConfig config = exactly();
  config.max_memory_mb = 1.0;
  MapImage image(config);
  image.update(map);
  EXPECT_FALSE(image.isCutOff());
  insertBeam(map, {1e5, 1e5, 0.0}, 9.05);
  image.update(map);
  EXPECT_TRUE(image.isCutOff());
  EXPECT_LE(image.image().cells.size(), 1000000U);
  EXPECT_EQ(percentAt(image.image(), {4.0, 0.05}), 97);
}

TEST(MapImage, RefusesAResolutionThatIsNotPositive) {
  MapImageConfig config;
  config.resolution_m = 0.0;
  EXPECT_THROW(MapImage{config}, ConfigError);
}

TEST(MapImage, ShowsWhatAQueryAnswersOrAnObstacleBesideIt) {
  HybridMapConfig config;
  RandomHistory history(config, 5);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(history.step());
  MapImageConfig only_ltrs = exactly();
  only_ltrs.include_waiting = false;
  MapImage image(only_ltrs);
  image.update(history.map());
  int known = 0, beside = 0;
  for (int y = 0; y < image.image().height; ++y) {
    for (int x = 0; x < image.image().width; ++x) {
      const LayerQuery answer = history.map().query("occupancy", image.image().centre(x, y));
      const int percent =
          answer.value ? static_cast<int>(std::lround(100.0 * answer.value->value)) : -1;
      if (image.image().at(x, y) != percent) {
        ASSERT_GE(int{image.image().at(x, y)}, std::max(50, percent)) << x << " " << y;
        ++beside;
      }
      if (answer.value) ++known;
    }
  }
  EXPECT_GT(known, 10000);
  EXPECT_LT(beside, known / 50);
}

TEST(MapImage, LosesNoOccupiedCellWhateverTheCellsDirection) {
  for (const double turn : {0.1, 0.4, 0.8}) {
    LandmarkMap landmarks = squareMap();
    const Pose2 T_map_wall{3.0, 2.0, turn};
    for (auto& landmark : landmarks.landmarks) landmark.position = T_map_wall * landmark.position;
    HybridMap map = mapOver(landmarks);
    for (double y = -8.0; y <= 8.0; y += 0.05)
      insertBeam(map, T_map_wall * Pose2{3.0, y, 0.0}, 2.0);
    MapImage image(exactly());
    image.update(map);
    for (double y = -8.0; y <= 8.0; y += 0.05) {
      EXPECT_EQ(greatestAround(image.image(), T_map_wall * Eigen::Vector2d(5.0, y)), 97) << y;
    }
  }
}

/// An image that was updated step by step, and a copy that was given only the patches, show the
/// same as one that is drawn at once.
RC_GTEST_PROP(MapImage, UpdatedStepByStepEqualsOneDrawnAtOnce, ()) {
  HybridMapConfig config;
  config.resolution_m = 0.5;
  RandomHistory history(config, *rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  MapImageConfig image_config = exactly();
  image_config.resolution_m = *rc::gen::element(0.4, 0.5, 0.7);
  MapImage image(image_config);
  OccupancyImage copy;
  for (int step = 0; step < 4; ++step) {
    RC_ASSERT(history.step());
    const ImageChange change = image.update(history.map());
    if (change.is_resized) copy = image.image();
    for (const ImagePatch& patch : change.patches) {
      const std::vector<std::int8_t> cells = cutOut(image.image(), patch);
      for (int y = 0; y < patch.height; ++y) {
        const auto row = cells.begin() + std::ptrdiff_t{y} * patch.width;
        std::copy(row, row + patch.width,
                  copy.cells.begin() + std::ptrdiff_t(copy.index(patch.x, patch.y + y)));
      }
    }
    RC_ASSERT(copy.cells == image.image().cells);
    MapImage at_once(image_config);
    at_once.update(history.map());
    RC_ASSERT(showTheSame(image.image(), at_once.image()));
  }
}

}  // namespace
}  // namespace hymm::core
