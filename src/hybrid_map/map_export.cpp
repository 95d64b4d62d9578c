#include "hybrid_map/map_export.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <octomap/OcTree.h>

#include "common/error.h"
#include "common/number_text.h"
#include "common/unfinished_file.h"

namespace hymm::core {
namespace {

// map_server's documented defaults. A pixel of kUnknownPixel gives a probability of exactly 50/255,
// which is not below kFreeThreshold.
constexpr double kOccupiedThreshold = 0.65, kFreeThreshold = 0.196;
constexpr std::uint8_t kOccupiedPixel = 0, kUnknownPixel = 205, kFreePixel = 254;

void refuseEmpty(const OccupancyImage& image, const std::string& path) {
  if (!image.cells.empty()) return;
  throw OutputError("'" + path + "' is not written: the map has no cells yet.");
}

/// `write` is given the stream. Throws OutputError if the disk does not take all of it.
template <class Write>
void fill(const UnfinishedFile& file, Write write) {
  std::ofstream stream(file.path(), std::ios::binary | std::ios::trunc);
  write(stream);
  stream.close();
  if (!stream) {
    throw OutputError("'" + file.path().string() + "' cannot be written: is the disk full?");
  }
}

std::uint8_t pixelOf(std::int8_t percent) {
  const std::int8_t trinary = trinaryOccupancy(percent);
  if (trinary < 0) return kUnknownPixel;
  return trinary == 0 ? kFreePixel : kOccupiedPixel;
}

void writePixels(const OccupancyImage& image, std::ostream& pgm) {
  pgm << "P5\n" << image.width << " " << image.height << "\n255\n";
  std::string row(static_cast<std::size_t>(image.width), '\0');
  for (int y = image.height - 1; y >= 0; --y) {  // the first row of a picture is its upper one
    for (int x = 0; x < image.width; ++x) {
      row[static_cast<std::size_t>(x)] = static_cast<char>(pixelOf(image.at(x, y)));
    }
    pgm << row;
  }
}

void writeDescription(const OccupancyImage& image, const std::string& pgm_path,
                      std::ostream& yaml) {
  const std::string name = pgm_path.substr(pgm_path.find_last_of('/') + 1);
  const Eigen::Vector2d origin = image.origin();
  yaml << "image: " << name << "\nmode: trinary\nresolution: " << numberText(image.resolution_m)
       << "\norigin: [" << numberText(origin.x()) << ", " << numberText(origin.y())
       << ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

}  // namespace

std::int8_t trinaryOccupancy(std::int8_t percent) {
  if (percent < 0) return OccupancyImage::kUnknown;
  if (percent > 100.0 * kOccupiedThreshold) return 100;
  return percent < 100.0 * kFreeThreshold ? 0 : OccupancyImage::kUnknown;
}

void exportPgm(const OccupancyImage& image, const std::string& path_without_extension) {
  const std::string pgm_path = path_without_extension + ".pgm";
  refuseEmpty(image, pgm_path);
  UnfinishedFile pgm(pgm_path), yaml(path_without_extension + ".yaml");
  fill(pgm, [&](std::ostream& stream) { writePixels(image, stream); });
  fill(yaml, [&](std::ostream& stream) { writeDescription(image, pgm_path, stream); });
  // Only when both are whole: they tell of each other.
  pgm.complete();
  yaml.complete();
}

void exportOctoMap(const OccupancyImage& image, const std::string& path) {
  refuseEmpty(image, path);
  constexpr int kReach = 32768;  // cells; keys have 16 bits
  const Eigen::Vector2i end = image.corner + Eigen::Vector2i(image.width, image.height);
  if (image.corner.minCoeff() < -kReach || end.maxCoeff() > kReach) {
    throw OutputError("'" + path + "' is not written: the map reaches farther than " +
                      std::to_string(kReach) + " cells from its origin, which an OctoMap cannot.");
  }
  octomap::OcTree tree(image.resolution_m);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::int8_t trinary = trinaryOccupancy(image.at(x, y));
      if (trinary < 0) continue;
      const octomap::OcTreeKey key(static_cast<octomap::key_type>(image.corner.x() + x + kReach),
                                   static_cast<octomap::key_type>(image.corner.y() + y + kReach),
                                   static_cast<octomap::key_type>(kReach));
      tree.setNodeValue(
          key, trinary > 0 ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog(), true);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
  UnfinishedFile file(path);
  fill(file, [&](std::ostream& stream) { tree.writeBinaryConst(stream); });
  file.complete();
}

}  // namespace hymm::core
