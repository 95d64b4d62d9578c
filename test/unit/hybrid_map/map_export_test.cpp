#include "hybrid_map/map_export.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <yaml-cpp/yaml.h>

#include "common/error.h"
#include "support/full_disk.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;

/// Every value from -1 to 100, and then free and occupied cells in turns.
OccupancyImage everyValue() {
  OccupancyImage image;
  image.resolution_m = 0.2;
  image.corner = {-37, 12};
  image.width = 17;
  image.height = 11;
  for (int i = 0; i < image.width * image.height; ++i) {
    const int value = i <= 101 ? i - 1 : (i % 2) * 100;
    image.cells.push_back(static_cast<std::int8_t>(value));
  }
  return image;
}

/// Reads a map as the documentation of map_server says, in mode trinary.
OccupancyImage readAsMapServer(const std::string& folder, const std::string& yaml_name) {
  const YAML::Node yaml = YAML::LoadFile(folder + "/" + yaml_name);
  std::ifstream pgm(folder + "/" + yaml["image"].as<std::string>(), std::ios::binary);
  std::string magic;
  int depth = 0;
  OccupancyImage image;
  pgm >> magic >> image.width >> image.height >> depth;
  pgm.get();
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(depth, 255);
  EXPECT_EQ(yaml["mode"].as<std::string>(), "trinary");
  image.resolution_m = yaml["resolution"].as<double>();
  const auto origin = yaml["origin"].as<std::vector<double>>();
  EXPECT_EQ(origin.at(2), 0.0);
  image.corner =
      (Eigen::Vector2d(origin[0], origin[1]) / image.resolution_m).array().round().cast<int>();
  image.cells.resize(std::size_t(image.width) * std::size_t(image.height));
  for (int row = 0; row < image.height; ++row) {
    for (int x = 0; x < image.width; ++x) {
      const double pixel = pgm.get();
      const double p = (yaml["negate"].as<int>() != 0 ? pixel : 255.0 - pixel) / 255.0;
      std::int8_t value = -1;
      if (p > yaml["occupied_thresh"].as<double>()) value = 100;
      if (p < yaml["free_thresh"].as<double>()) value = 0;
      image.cells[image.index(x, image.height - 1 - row)] = value;
    }
  }
  EXPECT_TRUE(pgm.good());
  pgm.get();
  EXPECT_TRUE(pgm.eof());
  return image;
}

TEST(MapExport, TellsTrinaryValuesByTheThresholdsThatItWrites) {
  EXPECT_EQ(trinaryOccupancy(-1), -1);
  EXPECT_EQ(trinaryOccupancy(0), 0);
  EXPECT_EQ(trinaryOccupancy(19), 0);
  EXPECT_EQ(trinaryOccupancy(20), -1);
  EXPECT_EQ(trinaryOccupancy(65), -1);
  EXPECT_EQ(trinaryOccupancy(66), 100);
  EXPECT_EQ(trinaryOccupancy(100), 100);
}

TEST(MapExport, MapServerReadsTheSameCells) {
  const test::TemporaryFolder folder;
  const OccupancyImage image = everyValue();
  exportPgm(image, folder / "map");
  const OccupancyImage read = readAsMapServer(folder.path().string(), "map.yaml");
  EXPECT_EQ(read.resolution_m, image.resolution_m);
  EXPECT_EQ(read.corner, image.corner);
  ASSERT_EQ(read.width, image.width);
  ASSERT_EQ(read.height, image.height);
  for (std::size_t i = 0; i < image.cells.size(); ++i) {
    EXPECT_EQ(read.cells[i], trinaryOccupancy(image.cells[i])) << i;
  }
}

TEST(MapExport, OctoMapReadsTheSameCells) {
  const test::TemporaryFolder folder;
  const OccupancyImage image = everyValue();
  exportOctoMap(image, folder / "map.bt");
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(folder / "map.bt"));
  EXPECT_EQ(tree.getResolution(), image.resolution_m);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector2d centre = image.centre(x, y);
      const octomap::OcTreeNode* node = tree.search(centre.x(), centre.y(), 0.1);
      const int value = node == nullptr ? -1 : (tree.isNodeOccupied(node) ? 100 : 0);
      EXPECT_EQ(value, trinaryOccupancy(image.at(x, y))) << x << " " << y;
      EXPECT_EQ(tree.search(centre.x(), centre.y(), 0.3), nullptr);
    }
  }
}

/// One cell, whose picture is much shorter than the description beside it.
OccupancyImage oneCell() {
  OccupancyImage image = everyValue();
  image.corner = {3, 4};
  image.width = image.height = 1;
  image.cells = {0};
  return image;
}

OccupancyImage inverse(OccupancyImage image) {
  for (std::int8_t& cell : image.cells) cell = static_cast<std::int8_t>(cell < 0 ? -1 : 100 - cell);
  return image;
}

std::size_t filesIn(const test::TemporaryFolder& folder) {
  const std::filesystem::directory_iterator files(folder.path());
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(MapExport, WhoReadsWhileItIsWrittenAgainFindsAWholeFile) {
  const test::TemporaryFolder folder;
  const auto writeAll = [&](const OccupancyImage& image) {
    exportPgm(image, folder / "map");
    exportOctoMap(image, folder / "map.bt");
  };
  writeAll(everyValue());
  for (const char* name : {"map.pgm", "map.yaml", "map.bt"}) {
    const std::string before = folder.read(name);
    std::ifstream reader;
    reader.rdbuf()->pubsetbuf(nullptr, 0);  // so that it reads no further than it is asked to
    reader.open(folder / name, std::ios::binary);
    std::string found(before.size() / 2, '\0');
    reader.read(found.data(), static_cast<std::streamsize>(found.size()));
    writeAll(oneCell());
    std::ostringstream rest;
    rest << reader.rdbuf();
    EXPECT_EQ(found + rest.str(), before) << name;
    EXPECT_NE(folder.read(name), before) << name;
    writeAll(everyValue());
  }
}

TEST(MapExport, AFullDiskLeavesTheFilesBefore) {
  const test::TemporaryFolder folder;
  exportPgm(everyValue(), folder / "map");
  exportOctoMap(everyValue(), folder / "map.bt");
  const std::string pgm = folder.read("map.pgm"), yaml = folder.read("map.yaml");
  const std::string octomap = folder.read("map.bt");
  {
    const test::FullDisk disk(20);
    EXPECT_THROW(exportPgm(inverse(everyValue()), folder / "map"), OutputError);
    // Its picture has room, its description has not: the old one would place the new picture wrong.
    EXPECT_THROW(exportPgm(oneCell(), folder / "map"), OutputError);
    EXPECT_THROW(exportOctoMap(inverse(everyValue()), folder / "map.bt"), OutputError);
  }
  EXPECT_EQ(folder.read("map.pgm"), pgm);
  EXPECT_EQ(folder.read("map.yaml"), yaml);
  EXPECT_EQ(folder.read("map.bt"), octomap);
  EXPECT_EQ(filesIn(folder), 3U);
}

TEST(MapExport, SaysWhyNothingIsWritten) {
  const test::TemporaryFolder folder;
  const auto problemOf = [](const auto& attempt) {
    try {
      attempt();
    } catch (const OutputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(problemOf([&] { exportPgm({}, folder / "map"); }), HasSubstr("no cells yet"));
  EXPECT_THAT(problemOf([&] { exportOctoMap({}, folder / "map.bt"); }), HasSubstr("no cells yet"));
  EXPECT_THAT(problemOf([&] { exportPgm(everyValue(), "/no/such/folder/map"); }),
              HasSubstr("/no/such/folder/map.pgm"));
  EXPECT_THAT(problemOf([&] { exportOctoMap(everyValue(), "/no/such/folder/map.bt"); }),
              HasSubstr("/no/such/folder/map.bt"));
  OccupancyImage far = everyValue();
  far.corner.x() = 32760;
  EXPECT_THAT(problemOf([&] { exportOctoMap(far, folder / "map.bt"); }),
              HasSubstr("farther than 32768 cells"));
}

}  // namespace
}  // namespace hymm::core
