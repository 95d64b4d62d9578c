#include "hybrid_map/geojson_export.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <yaml-cpp/yaml.h>

#include "common/error.h"
#include "hybrid_map/map_export.h"
#include "hybrid_map/occupied_outlines.h"
#include "landmark_maps.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

OccupancyImage imageOf(int width, int height) {
  OccupancyImage image;
  image.resolution_m = 0.25;
  image.corner = {-7, 3};
  image.width = width;
  image.height = height;
  image.cells.assign(std::size_t(width) * std::size_t(height), OccupancyImage::kUnknown);
  return image;
}

/// Winding number of a ring around a place.
int windings(const std::vector<Eigen::Vector2d>& ring, const Eigen::Vector2d& place) {
  double turn = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i] - place, b = ring[(i + 1) % ring.size()] - place;
    turn += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return static_cast<int>(std::lround(turn / (2.0 * kPi)));
}

std::vector<Eigen::Vector2d> placesOf(const CellRing& ring) {
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector2i& corner : ring) places.emplace_back(corner.cast<double>());
  return places;
}

bool visitsNoCornerTwice(CellRing ring) {
  const auto less = [](const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
    return std::make_pair(a.x(), a.y()) < std::make_pair(b.x(), b.y());
  };
  std::sort(ring.begin(), ring.end(), less);
  return std::adjacent_find(ring.begin(), ring.end()) == ring.end();
}

RC_GTEST_PROP(OccupiedOutlines, GoAroundTheOccupiedCellsAndNoOthers, ()) {
  RandomGenerator generator(*rc::gen::inRange<std::uint64_t>(0, 1ULL << 40U));
  OccupancyImage image = imageOf(*rc::gen::inRange(1, 12), *rc::gen::inRange(1, 12));
  const double share = sampleUniform(generator, 0.2, 0.9);
  for (std::int8_t& cell : image.cells) cell = sampleUniform(generator, 0.0, 1.0) < share ? 90 : 5;
  const std::vector<CellPolygon> polygons = occupiedOutlines(image);
  for (const CellPolygon& polygon : polygons) {
    RC_ASSERT(visitsNoCornerTwice(polygon.outline));
    for (const CellRing& hole : polygon.holes) RC_ASSERT(visitsNoCornerTwice(hole));
  }
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector2d middle =
          image.corner.cast<double>() + Eigen::Vector2d(x + 0.5, y + 0.5);
      int around = 0;
      for (const CellPolygon& polygon : polygons) {
        const int outside = windings(placesOf(polygon.outline), middle);
        RC_ASSERT(outside == 0 || outside == 1);
        around += outside;
        for (const CellRing& hole : polygon.holes) around += windings(placesOf(hole), middle);
      }
      RC_ASSERT(around == (image.at(x, y) > 65 ? 1 : 0));
    }
  }
}

TEST(OccupiedOutlines, OfARectangleHasFourCorners) {
  OccupancyImage image = imageOf(5, 4);
  for (int x = 1; x < 4; ++x) image.cells[image.index(x, 2)] = 100;
  const std::vector<CellPolygon> polygons = occupiedOutlines(image);
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_EQ(polygons[0].outline.size(), 4U);
  EXPECT_TRUE(polygons[0].holes.empty());
  EXPECT_THAT(polygons[0].outline, testing::Contains(Eigen::Vector2i(-7 + 4, 3 + 3)));
}

class GeoJson : public testing::Test {
 protected:
  GeoJson() : map_(HybridMapConfig()), landmarks_(mapOf({{0.0, 0.1}, {20.0, 0.0}, {9.0, 17.3}})) {
    landmarks_.landmarks[1].type = LandmarkType::kTrunk;
    landmarks_.landmarks[1].diameter_m = 0.35;
    landmarks_.landmarks[2].diameter_m = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(map_.apply(landmarks_).accepted);
  }

  /// The features of one kind.
  std::vector<YAML::Node> read(const std::string& kind) const {
    const YAML::Node root = YAML::Load(folder_.read("map.geojson"));
    EXPECT_EQ(root["type"].as<std::string>(), "FeatureCollection");
    std::vector<YAML::Node> features;
    for (const YAML::Node& feature : root["features"]) {
      EXPECT_EQ(feature["type"].as<std::string>(), "Feature");
      if (feature["properties"]["kind"].as<std::string>() == kind) features.push_back(feature);
    }
    return features;
  }
  static Eigen::Vector2d place(const YAML::Node& position) {
    return {position[0].as<double>(), position[1].as<double>()};
  }

  test::TemporaryFolder folder_;
  HybridMap map_;
  LandmarkMap landmarks_;
};

TEST_F(GeoJson, GivesBackLtrsAndLandmarks) {
  exportGeoJson(map_, landmarks_, {}, folder_ / "map.geojson");
  const std::vector<YAML::Node> ltrs = read("ltr");
  ASSERT_EQ(ltrs.size(), 1U);
  EXPECT_EQ(ltrs[0]["geometry"]["type"].as<std::string>(), "Polygon");
  const YAML::Node ring = ltrs[0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 4U);
  EXPECT_EQ(place(ring[0]), place(ring[3]));
  EXPECT_GT(ltrs[0]["properties"]["shape_factor"].as<double>(), 1.0);
  const YAML::Node ids = ltrs[0]["properties"]["landmarks"];
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(place(ring[k]), landmarks_.landmarks[ids[k].as<std::size_t>()].position);
  }
  const std::vector<YAML::Node> points = read("landmark");
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(place(points[2]["geometry"]["coordinates"]), landmarks_.landmarks[2].position);
  EXPECT_EQ(points[1]["properties"]["type"].as<std::string>(), "trunk");
  EXPECT_EQ(points[1]["properties"]["diameter_m"].as<double>(), 0.35);
  EXPECT_TRUE(points[2]["properties"]["diameter_m"].IsNull());
  EXPECT_NEAR(points[1]["properties"]["deviation_m"].as<double>(), 0.1, 1e-12);
}

TEST_F(GeoJson, FollowsTheLandmarks) {
  LandmarkUpdate update;
  update.since_version = 1;
  update.version = 2;
  update.changed = {landmarks_.landmarks[2]};
  update.changed[0].position = {9.5, 17.0};
  ASSERT_TRUE(map_.apply(update).accepted);
  exportGeoJson(map_, landmarks_, {}, folder_ / "map.geojson");
  EXPECT_EQ(place(read("landmark")[2]["geometry"]["coordinates"]), Eigen::Vector2d(9.5, 17.0));
  const YAML::Node ring = read("ltr")[0]["geometry"]["coordinates"][0];
  EXPECT_THAT((std::vector<Eigen::Vector2d>{place(ring[0]), place(ring[1]), place(ring[2])}),
              testing::Contains(Eigen::Vector2d(9.5, 17.0)));
}

TEST_F(GeoJson, GivesBackTheOutlinesOfWhatIsOccupied) {
  OccupancyImage image = imageOf(6, 6);
  for (int y = 1; y <= 3; ++y) {
    for (int x = 1; x <= 3; ++x) image.cells[image.index(x, y)] = x == 2 && y == 2 ? 0 : 100;
  }
  image.cells[image.index(5, 5)] = 80;
  exportGeoJson(map_, landmarks_, image, folder_ / "map.geojson");
  const std::vector<YAML::Node> occupied = read("occupied");
  ASSERT_EQ(occupied.size(), 1U);
  EXPECT_EQ(occupied[0]["geometry"]["type"].as<std::string>(), "MultiPolygon");
  const YAML::Node polygons = occupied[0]["geometry"]["coordinates"];
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      int around = 0;
      for (const YAML::Node& polygon : polygons) {
        for (const YAML::Node& ring : polygon) {
          std::vector<Eigen::Vector2d> places;
          for (const YAML::Node& position : ring) places.push_back(place(position));
          EXPECT_EQ(places.front(), places.back());
          around += windings(places, image.centre(x, y));
        }
      }
      EXPECT_EQ(around, trinaryOccupancy(image.at(x, y)) > 0 ? 1 : 0) << x << " " << y;
    }
  }
}

TEST_F(GeoJson, SaysWhyNothingIsWritten) {
  const auto problemOf = [](const auto& attempt) {
    try {
      attempt();
    } catch (const OutputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(problemOf([&] {
                exportGeoJson(HybridMap(HybridMapConfig()), {}, {}, folder_ / "map.geojson");
              }),
              HasSubstr("no landmarks and no cells yet"));
  EXPECT_THAT(
      problemOf([&] { exportGeoJson(map_, landmarks_, {}, "/no/such/folder/map.geojson"); }),
      HasSubstr("/no/such/folder"));
}

}  // namespace
}  // namespace hymm::core
