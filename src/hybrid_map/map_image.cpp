#include "hybrid_map/map_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "hybrid_map/image_painter.h"

namespace hymm::core {
namespace {

// An image that grows gets room to spare, so that it seldom does.
constexpr int kSpareTiles = 4;
constexpr double kBytesPerMb = 1e6;
constexpr double kNowhere = std::numeric_limits<double>::infinity();

MapImageConfig checked(const MapImageConfig& config) {
  MapImageConfig copy = config;
  ConfigSchema schema;
  copy.describe(schema);
  const std::vector<std::string> problems = rangeProblems(schema);
  if (!problems.empty()) throw ConfigError(problems);
  return config;
}

ConvexRegion regionOf(const Triangle& triangle) {
  return {triangle.vertex(0), triangle.vertex(1), triangle.vertex(2), triangle.vertex(2)};
}

ConvexRegion regionOf(const WaitingTile& tile) {
  const double edge = WaitingTile::kCells * tile.resolution_m;
  return {tile.T_map_cells * Eigen::Vector2d(0.0, 0.0),
          tile.T_map_cells * Eigen::Vector2d(edge, 0.0),
          tile.T_map_cells * Eigen::Vector2d(edge, edge),
          tile.T_map_cells * Eigen::Vector2d(0.0, edge)};
}

double farthestShift(const ConvexRegion& a, const ConvexRegion& b) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) farthest = std::max(farthest, (a[i] - b[i]).norm());
  return farthest;
}

}  // namespace

void MapImageConfig::describe(ConfigSchema& schema) {
  schema.number("resolution_m", resolution_m, Range{0.005, 10.0, false},
                "side of a cell of the image");
  schema.number("redraw_shift_cells", redraw_shift_cells, Range::between(0.0, 10.0),
                "that an LTR's corner moves before the LTR is drawn anew");
  schema.flag("include_waiting", include_waiting,
              "draw also what lies outside of all LTRs and waits for one");
  schema.number("max_memory_mb", max_memory_mb, Range::positive(),
                "for the image, a byte a cell; what lies beyond is left out");
}

MapImage::MapImage(const MapImageConfig& config) : config_(checked(config)) {
  image_.resolution_m = config_.resolution_m;
}

ImageChange MapImage::update(const HybridMap& map) {
  ++updates_;
  changed_.clear();
  low_.setConstant(kNowhere);
  high_.setConstant(-kNowhere);
  findChangedLtrs(map);
  if (config_.include_waiting) findChangedWaiting(map);

  ImageChange change;
  change.is_resized = grow();
  ImageTiles tiles(image_.width / ImageTiles::kCells, image_.height / ImageTiles::kCells);
  for (const ConvexRegion& region : changed_) tiles.setUnder(region, image_);
  std::vector<std::vector<std::int8_t>> before;
  tiles.visit([&](int x, int y) { before.push_back(cutOut(image_, ImageTiles::patchOf(x, y))); });
  clear(tiles);
  if (config_.include_waiting) drawWaiting(map, tiles);
  drawLtrs(map, tiles);
  ImageTiles different = tiles;
  std::size_t i = 0;
  tiles.visit([&](int x, int y) {
    different.set(x, y, cutOut(image_, ImageTiles::patchOf(x, y)) != before[i++]);
  });
  change.patches = different.patches();
  return change;
}

/// Takes note of where something is now; where it was and is, if it is not drawn like that.
void MapImage::look(Drawn& drawn, const ConvexRegion& region, std::uint64_t revision) {
  drawn.update = updates_;
  for (const Eigen::Vector2d& corner : region) {
    low_ = low_.min(corner.array());
    high_ = high_.max(corner.array());
  }
  const double tolerance_m = config_.redraw_shift_cells * config_.resolution_m;
  const bool moved = drawn.revision == 0 || farthestShift(drawn.region, region) > tolerance_m;
  if (!moved && drawn.revision == revision) return;
  if (drawn.revision != 0) changed_.push_back(drawn.region);
  if (moved) {
    drawn.region = region;
    changed_.push_back(region);
  }
  drawn.revision = revision;
}

void MapImage::forget(Drawn& drawn) {
  if (drawn.revision != 0) changed_.push_back(drawn.region);
  drawn = {};
}

void MapImage::findChangedLtrs(const HybridMap& map) {
  const LtrMesh& mesh = map.partition().mesh();
  ltrs_.resize(std::max(ltrs_.size(), std::size_t(mesh.ltrEnd())));
  for (std::size_t i = 0; i < ltrs_.size(); ++i) {
    const int ltr = static_cast<int>(i);
    const LtrCells* cells = map.cells(ltr);
    const bool is_written = cells != nullptr && !cells->store.isEmpty(LayerSet::kOccupancy);
    if (is_written) {
      look(ltrs_[i], regionOf(mesh.ltr(ltr).triangle), cells->store.revision(LayerSet::kOccupancy));
    } else {
      forget(ltrs_[i]);
    }
  }
}

void MapImage::findChangedWaiting(const HybridMap& map) {
  map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
    look(waiting_[{tile.sheet, tile.x, tile.y}], regionOf(tile),
         tile.cells->revision(LayerSet::kOccupancy));
  });
  for (auto drawn = waiting_.begin(); drawn != waiting_.end();) {
    if (drawn->second.update == updates_) {
      ++drawn;
    } else {
      forget(drawn->second);
      drawn = waiting_.erase(drawn);
    }
  }
}

/// Makes room for everything that is known. Returns whether the image has another size now.
bool MapImage::grow() {
  is_cut_off_ = false;
  if (!(low_ <= high_).all()) return false;
  constexpr int kCells = ImageTiles::kCells;
  const double tile_m = kCells * config_.resolution_m;
  const Eigen::Array2d first = (low_ / tile_m).floor(), end = (high_ / tile_m).floor() + 1.0;
  const Eigen::Array2d had_first = image_.corner.cast<double>().array() / kCells;
  const Eigen::Array2d had_end = had_first + Eigen::Array2d(image_.width, image_.height) / kCells;
  const bool is_new = image_.cells.empty();
  if (!is_new && (first >= had_first).all() && (end <= had_end).all()) return false;

  Eigen::Array2d now_first = first - kSpareTiles, now_end = end + kSpareTiles;
  if (!is_new) {
    now_first = (first < had_first).select(now_first, had_first);
    now_end = (end > had_end).select(now_end, had_end);
  }
  const double bytes = (now_end - now_first).prod() * kCells * kCells;
  if (bytes > config_.max_memory_mb * kBytesPerMb) {
    is_cut_off_ = true;
    return false;
  }
  OccupancyImage grown;
  grown.resolution_m = image_.resolution_m;
  grown.corner = (now_first * kCells).cast<int>();
  grown.width = static_cast<int>((now_end - now_first).x()) * kCells;
  grown.height = static_cast<int>((now_end - now_first).y()) * kCells;
  grown.cells.assign(static_cast<std::size_t>(bytes), OccupancyImage::kUnknown);
  const Eigen::Vector2i shift = image_.corner - grown.corner;
  for (int y = 0; y < image_.height; ++y) {
    const auto row = image_.cells.begin() + std::ptrdiff_t(image_.index(0, y));
    std::copy(row, row + image_.width,
              grown.cells.begin() + std::ptrdiff_t(grown.index(shift.x(), y + shift.y())));
  }
  image_ = std::move(grown);
  return true;
}

void MapImage::clear(const ImageTiles& tiles) {
  tiles.visit([&](int tile_x, int tile_y) {
    const ImagePatch patch = ImageTiles::patchOf(tile_x, tile_y);
    for (int y = patch.y; y < patch.y + patch.height; ++y) {
      const auto row = image_.cells.begin() + std::ptrdiff_t(image_.index(patch.x, y));
      std::fill(row, row + patch.width, OccupancyImage::kUnknown);
    }
  });
}

void MapImage::drawWaiting(const HybridMap& map, const ImageTiles& tiles) {
  std::map<std::pair<int, int>, std::vector<WaitingTile>> above;  // by tile of the image
  map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
    for (const TileRow& row : tilesUnder(regionOf(tile), image_)) {
      for (int x = row.first; x < row.end; ++x) {
        if (tiles.has(x, row.y)) above[{x, row.y}].push_back(tile);
      }
    }
  });
  std::vector<float> log_odds, buffer;
  std::vector<OccupiedSpot> occupied;
  for (const auto& [at, squares] : above) {
    const ImagePatch patch = ImageTiles::patchOf(at.first, at.second);
    log_odds.assign(std::size_t(patch.width) * std::size_t(patch.height), 0.0F);
    for (const WaitingTile& tile : squares) {
      const std::vector<float>& content = tile.cells->peek(LayerSet::kOccupancy, buffer);
      const WaitingSquare square{tile.T_map_cells, tile.resolution_m, WaitingTile::kCells,
                                 content.data()};
      addSquare(square, patch, image_, log_odds);
      findOccupied(square, tiles, image_, occupied);
    }
    for (int y = 0; y < patch.height; ++y) {
      const auto row = log_odds.begin() + std::ptrdiff_t{y} * patch.width;
      std::transform(row, row + patch.width,
                     image_.cells.begin() + std::ptrdiff_t(image_.index(patch.x, patch.y + y)),
                     occupancyPercent);
    }
  }
  // Cells of several sheets over one place seldom coincide: what one of them is sure is occupied
  // stands, or a thin wall would be averaged away.
  for (const OccupiedSpot& spot : occupied) {
    image_.cells[spot.index] = std::max(image_.cells[spot.index], spot.percent);
  }
}

void MapImage::drawLtrs(const HybridMap& map, const ImageTiles& tiles) {
  std::vector<float> buffer;
  std::vector<OccupiedSpot> occupied;
  for (std::size_t i = 0; i < ltrs_.size(); ++i) {
    if (ltrs_[i].revision == 0) continue;
    const LtrCells& cells = *map.cells(static_cast<int>(i));
    const Triangle& triangle = map.partition().mesh().ltr(static_cast<int>(i)).triangle;
    const std::vector<float>* content = nullptr;
    for (const TileRow& row : tilesUnder(regionOf(triangle), image_)) {
      tiles.visitRuns(row.y, row.first, row.end, [&](int x, int count) {
        if (content == nullptr) content = &cells.store.peek(LayerSet::kOccupancy, buffer);
        paintLtr(cells.grid, triangle, content->data(), ImageTiles::patchOf(x, row.y, count),
                 image_);
      });
    }
    if (content != nullptr) {
      findOccupied(cells.grid, triangle, content->data(), tiles, image_, occupied);
    }
  }
  for (const OccupiedSpot& spot : occupied) {
    image_.cells[spot.index] = std::max(image_.cells[spot.index], spot.percent);
  }
}

}  // namespace hymm::core
