#include "hybrid_map/waiting_tiles.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include "hybrid_map/cell_shares.h"

namespace hymm::core {
namespace {

// Nearer to each other, two landmarks do not tell a direction well; and hardly any.
constexpr double kAnchorSeparation_m = 10.0;
constexpr double kLeastAnchorSeparation_m = 3.0;

constexpr double kBytesPerMb = 1e6;

int floorDivide(int value, int divisor) {
  return value >= 0 ? value / divisor : -((-value + divisor - 1) / divisor);
}

}  // namespace

void WaitingConfig::describe(ConfigSchema& schema) {
  schema.number("anchor_range_m", anchor_range_m, Range::positive(),
                "from the sensor to landmarks that observations outside of all LTRs are kept by");
  schema.number(
      "max_memory_mb", max_memory_mb, Range::positive(),
      "for observations outside of all LTRs, of which those of one scan must fit; beyond, "
      "the oldest are dropped and counted");
}

double WaitingConfig::scanMemory_mb(double range_m, double resolution_m) {
  // Log-odds, when seen, and a mark.
  constexpr double kBytes = sizeof(float) + sizeof(CellStore::Stamp) + CellMarks::kBytesPerCell;
  // All tiles that the disc touches lie within the disc that is wider by a tile's diagonal.
  const double radius = range_m / (WaitingTile::kCells * resolution_m) + M_SQRT2;
  const double cells = M_PI * radius * radius * WaitingTile::kCells * WaitingTile::kCells;
  return cells * kBytes / kBytesPerMb;
}

WaitingTiles::WaitingTiles(const WaitingConfig& config, const LayerSet& layers, double resolution_m)
    : config_(config), layers_(layers), resolution_m_(resolution_m) {}

bool WaitingTiles::areThere(const std::pair<int, int>& anchors,
                            const LandmarkPlaces& landmarks) const {
  return (anchors.first < 0 || landmarks.find(anchors.first)) &&
         (anchors.second < 0 || landmarks.find(anchors.second));
}

/// Stands at the first anchor, x axis towards the second. With fewer: map's axes, and origin.
Pose2 WaitingTiles::anchorFrame(const std::pair<int, int>& anchors,
                                const LandmarkPlaces& landmarks) const {
  const auto first = anchors.first < 0 ? std::nullopt : landmarks.find(anchors.first);
  if (!first) return {};
  const auto second = anchors.second < 0 ? std::nullopt : landmarks.find(anchors.second);
  if (!second) return {first->x(), first->y(), 0.0};
  const Eigen::Vector2d along = *second - *first;
  return {first->x(), first->y(), std::atan2(along.y(), along.x())};
}

void WaitingTiles::anchor(Sheet& sheet, const Eigen::Vector2d& place,
                          const LandmarkPlaces& landmarks) const {
  for (const double separation_m : {kAnchorSeparation_m, kLeastAnchorSeparation_m}) {
    sheet.anchors = landmarks.nearestTwo(place, config_.anchor_range_m, separation_m);
    if (sheet.anchors.second >= 0) break;
  }
  sheet.T_anchors_sheet = inverse(anchorFrame(sheet.anchors, landmarks)) * sheet.T_map_sheet;
}

bool WaitingTiles::suits(const Sheet& sheet, const Eigen::Vector2d& place,
                         const LandmarkPlaces& landmarks) const {
  const auto isNear = [&](int id) {
    const auto anchor = id < 0 ? std::nullopt : landmarks.find(id);
    return anchor && (*anchor - place).norm() <= config_.anchor_range_m;
  };
  return isNear(sheet.anchors.first) && isNear(sheet.anchors.second);
}

/// Where a sheet is near, it is written on, whichever landmarks are nearest: else what is seen of
/// one place from several would lie in as many sheets.
void WaitingTiles::select(const Eigen::Vector2d& place, const LandmarkPlaces& landmarks) {
  last_tile_ = nullptr;
  if (selected_ >= sheets_.size() || !suits(sheets_[selected_], place, landmarks)) {
    selected_ = nearestSuiting(place, landmarks);
  }
  if (selected_ == sheets_.size()) {
    Sheet sheet;
    anchor(sheet, place, landmarks);
    const auto known = std::find_if(sheets_.begin(), sheets_.end(), [&](const Sheet& other) {
      return other.anchors == sheet.anchors;
    });
    selected_ = static_cast<std::size_t>(known - sheets_.begin());
    if (known == sheets_.end()) {
      sheet.id = ++sheets_made_;
      sheets_.push_back(std::move(sheet));
    }
  }
  T_cells_map_ = inverse(sheets_[selected_].T_map_sheet);
}

/// The suiting sheet whose anchors are nearest; one past the last if none suits.
std::size_t WaitingTiles::nearestSuiting(const Eigen::Vector2d& place,
                                         const LandmarkPlaces& landmarks) const {
  std::size_t nearest = sheets_.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sheets_.size(); ++i) {
    if (!suits(sheets_[i], place, landmarks)) continue;
    const double distance = (anchorMiddle(sheets_[i], landmarks) - place).norm();
    if (distance >= least) continue;
    nearest = i;
    least = distance;
  }
  return nearest;
}

CellPlace WaitingTiles::cell(int i, int j, std::uint64_t revision) {
  const TilePlace place(floorDivide(i, kTileCells), floorDivide(j, kTileCells));
  if (last_tile_ == nullptr || place != last_place_) {
    auto& tiles = sheets_[selected_].tiles;
    last_tile_ = &tiles.try_emplace(place, layers_, kTileCells * kTileCells, kSeen).first->second;
    last_place_ = place;
    sheets_[selected_].written = revision;
  }
  return {last_tile_,
          (j - place.second * kTileCells) * kTileCells + (i - place.first * kTileCells)};
}

CellPlace WaitingTiles::cellAt(const Eigen::Vector2d& place, std::uint64_t revision) {
  const Eigen::Vector2d cells = toCells(place);
  return cell(static_cast<int>(std::floor(cells.x())), static_cast<int>(std::floor(cells.y())),
              revision);
}

/// Of a cell that moves.
CellPart WaitingTiles::movingPart(const CellStore& tile, int layer, int index) const {
  const float* cell = tile.read(layers_, layer, index);
  return partOf(layers_, tile, layer, index, partsOf(layers_.model(layer), cell));
}

Eigen::Vector2d WaitingTiles::centreOf(const Sheet& sheet) const {
  const double tile_m = kTileCells * resolution_m_;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& [place, tile] : sheet.tiles) {
    sum += tile_m * (Eigen::Vector2d(place.first, place.second).array() + 0.5).matrix();
  }
  return sheet.T_map_sheet *
         (sum / static_cast<double>(std::max<std::size_t>(1, sheet.tiles.size())));
}

Eigen::Vector2d WaitingTiles::centreOf(const Sheet& sheet, const TilePlace& tile) const {
  const Eigen::Vector2d middle(tile.first + 0.5, tile.second + 0.5);
  return sheet.T_map_sheet * (kTileCells * resolution_m_ * middle);
}

void WaitingTiles::follow(const LandmarkPlaces& landmarks) {
  last_tile_ = nullptr;
  forgetEmptySheets();
  for (Sheet& sheet : sheets_) {
    const bool all_there = areThere(sheet.anchors, landmarks);
    if (all_there) {
      sheet.T_map_sheet = anchorFrame(sheet.anchors, landmarks) * sheet.T_anchors_sheet;
    }
    // From here on it stays where it is with respect to landmarks that are there.
    const bool has_two = sheet.anchors.first >= 0 && sheet.anchors.second >= 0;
    if (!all_there || !has_two) anchor(sheet, centreOf(sheet), landmarks);
  }
}

void WaitingTiles::forgetEmptySheets() {
  const auto end = std::remove_if(sheets_.begin(), sheets_.end(),
                                  [](const Sheet& sheet) { return sheet.tiles.empty(); });
  if (end == sheets_.end()) return;
  sheets_.erase(end, sheets_.end());
  selected_ = sheets_.size();  // none
  const auto isThere = [this](std::uint64_t id) {
    return std::any_of(sheets_.begin(), sheets_.end(),
                       [id](const Sheet& sheet) { return sheet.id == id; });
  };
  for (auto pair = joined_.begin(); pair != joined_.end();) {
    const bool stays = isThere(pair->first.first) && isThere(pair->first.second);
    pair = stays ? std::next(pair) : joined_.erase(pair);
  }
}

CellMemory WaitingTiles::memory() const {
  CellMemory memory;
  for (const Sheet& sheet : sheets_) {
    for (const auto& [place, tile] : sheet.tiles) tile.addMemory(memory);
  }
  return memory;
}

void WaitingTiles::packBeyond(const Eigen::Vector2d& place, double radius_m,
                              std::uint64_t since_revision) {
  last_tile_ = nullptr;
  const double tile_m = kTileCells * resolution_m_;
  for (Sheet& sheet : sheets_) {
    for (auto& [at, tile] : sheet.tiles) {
      const double distance_m = (centreOf(sheet, at) - place).norm();
      if (distance_m > radius_m + tile_m) tile.pack(since_revision);
    }
  }
}

std::size_t WaitingTiles::dropBeyondLimit(const Eigen::Vector2d& vehicle) {
  std::size_t tiles = 0;
  for (const Sheet& sheet : sheets_) tiles += sheet.tiles.size();
  double cell_bytes = layers_.channelsTogether() * static_cast<double>(sizeof(float));
  for (int layer = 0; layer < layers_.count(); ++layer) {
    if (!layers_.model(layer).hasLimits()) continue;
    cell_bytes += sizeof(CellStore::Stamp) + CellMarks::kBytesPerCell;
  }
  const double limit = config_.max_memory_mb * kBytesPerMb;
  const auto most = static_cast<double>(tiles) * kTileCells * kTileCells * cell_bytes;
  if (most <= limit) return 0;  // even if nothing is packed
  const auto used = static_cast<double>(memory().bytes());
  return used > limit ? drop(used - limit, vehicle) : 0;
}

/// Frees so many bytes at least. A scan may bring thousands of tiles at once, all of one revision,
/// so tiles are put in order once and not searched for each.
std::size_t WaitingTiles::drop(double bytes, const Eigen::Vector2d& vehicle) {
  struct Droppable {
    std::uint64_t revision;
    double distance_m;
    Sheet* sheet;
    std::map<TilePlace, CellStore>::iterator tile;
  };
  const auto goesLater = [](const Droppable& a, const Droppable& b) {
    return std::make_tuple(a.revision, -a.distance_m, a.sheet->id, a.tile->first) >
           std::make_tuple(b.revision, -b.distance_m, b.sheet->id, b.tile->first);
  };
  std::vector<Droppable> heap;
  for (Sheet& sheet : sheets_) {
    for (auto tile = sheet.tiles.begin(); tile != sheet.tiles.end(); ++tile) {
      const double distance_m = (centreOf(sheet, tile->first) - vehicle).norm();
      heap.push_back({tile->second.lastRevision(), distance_m, &sheet, tile});
    }
  }
  std::make_heap(heap.begin(), heap.end(), goesLater);
  last_tile_ = nullptr;
  std::size_t dropped = 0;
  for (; bytes > 0.0 && !heap.empty(); ++dropped) {
    std::pop_heap(heap.begin(), heap.end(), goesLater);
    const Droppable first = heap.back();
    heap.pop_back();
    CellMemory freed;
    first.tile->second.addMemory(freed);
    bytes -= static_cast<double>(freed.bytes());
    first.sheet->tiles.erase(first.tile);
  }
  return dropped;
}

double WaitingTiles::evidence(int layer) const {
  double sum = 0.0;
  for (const Sheet& sheet : sheets_) {
    for (const auto& [place, tile] : sheet.tiles) {
      if (tile.isEmpty(layer)) continue;
      for (int cell = 0; cell < tile.cellCount(); ++cell) {
        sum += layers_.model(layer).evidence(tile.read(layers_, layer, cell));
      }
    }
  }
  return sum;
}

}  // namespace hymm::core
