/// What is saved of the dense map, and how it is checked when it comes back.
#include <algorithm>
#include <utility>

#include "common/state_archive.h"
#include "hybrid_map/layer_writer.h"

namespace hymm::core {
namespace {

constexpr long long kMostCells = 1LL << 26U;

bool isIndex(int index, int end) { return index >= 0 && index < end; }

}  // namespace

bool LtrIndex::isBelow(int end) const {
  const auto is_below = [end](int ltr) { return isIndex(ltr, end); };
  return cells_.size() <= std::size_t(end) &&
         std::all_of(content_.begin(), content_.end(), [&](const auto& cell) {
           return std::all_of(cell.second.begin(), cell.second.end(), [&](int ltr) {
             return is_below(ltr) && std::size_t(ltr) < cells_.size();
           });
         });
}

bool LtrPartition::isBelow(const std::vector<int>& ltrs, int end) {
  return std::all_of(ltrs.begin(), ltrs.end(), [end](int ltr) { return isIndex(ltr, end); });
}

bool LtrMesh::countAlive() {
  alive_ = 0;
  bool fits = true;
  for (const Ltr& ltr : ltrs_) {
    if (!ltr.is_alive) continue;
    ++alive_;
    for (const int v : ltr.vertices) fits = fits && isIndex(v, vertexEnd());
    for (const int n : ltr.neighbours) fits = fits && (n == kNone || isIndex(n, ltrEnd()));
  }
  for (const MeshVertex& vertex : vertices_) {
    fits = fits && vertex.position.allFinite();
    for (const int ltr : vertex.ltrs) fits = fits && isIndex(ltr, ltrEnd());
  }
  for (const int v : free_vertices_) fits = fits && isIndex(v, vertexEnd());
  for (const auto& [id, v] : vertex_of_landmark_) fits = fits && isIndex(v, vertexEnd());
  for (const auto& [side, ltr] : ltr_of_side_) fits = fits && isIndex(ltr, ltrEnd());
  return fits;
}

void CellStore::save(StateWriter& archive) const {
  std::vector<float> buffer;
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    archive(revisions_[i], seen_[i], layers_[i].isPacked(), peek(static_cast<int>(i), buffer),
            layers_[i].seen_cells, layers_[i].noted_at_limit.bits());
  }
}

void CellStore::restore(const LayerSet& layers, StateReader& archive) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    std::vector<float> content;
    bool is_packed = false;
    std::vector<Stamp> seen_cells;
    std::vector<std::uint8_t> noted_at_limit;
    archive(revisions_[i], seen_[i], is_packed, content, seen_cells, noted_at_limit);
    const auto channels = std::size_t(layers.channels(static_cast<int>(i)));
    const std::size_t size = revisions_[i] == 0 ? 0 : std::size_t(cells_) * channels;
    archive.require(content.size() == size, "a layer has another number of cells than its region");
    const bool has_seen_cells = layers_[i].keeps_seen_cells && !is_packed && size > 0;
    archive.require(seen_cells.size() == (has_seen_cells ? std::size_t(cells_) : 0U),
                    "it does not tell of each cell when it was seen");
    archive.require(size > 0 ? CellMarks::fit(noted_at_limit, cells_) : noted_at_limit.empty(),
                    "it tells of another number of cells whether they were at a limit");
    layers_[i].noted_at_limit.setBits(std::move(noted_at_limit));
    if (is_packed) layers_[i].noted_at_limit.pack();
    layers_[i].tree = {};
    layers_[i].packed = is_packed && size > 0 ? PackedFloats(content) : PackedFloats();
    if (is_packed) content.clear();
    layers_[i].content = std::move(content);
    layers_[i].seen_cells = std::move(seen_cells);
  }
}

void WaitingTiles::save(StateWriter& archive) const {
  archive(sheets_made_, selected_, T_cells_map_, sheets_.size());
  for (const Sheet& sheet : sheets_) {
    archive(sheet.id, sheet.anchors, sheet.T_map_sheet, sheet.T_anchors_sheet, sheet.written,
            sheet.tiles.size());
    for (const auto& [place, cells] : sheet.tiles) {
      archive(place);
      cells.save(archive);
    }
  }
  archive(joined_);
}

void WaitingTiles::restore(StateReader& archive) {
  sheets_.clear();
  last_tile_ = nullptr;
  archive(sheets_made_, selected_, T_cells_map_);
  for (std::size_t left = archive.readSize(); left > 0; --left) {
    Sheet& sheet = sheets_.emplace_back();
    archive(sheet.id, sheet.anchors, sheet.T_map_sheet, sheet.T_anchors_sheet, sheet.written);
    for (std::size_t tiles = archive.readSize(); tiles > 0; --tiles) {
      const auto place = archive.read<TilePlace>();
      CellStore& cells =
          sheet.tiles.try_emplace(place, layers_, kTileCells * kTileCells, kSeen).first->second;
      cells.restore(layers_, archive);
    }
  }
  archive(joined_);
}

void LayerWriter::save(StateWriter& archive) const {
  archive(revision_, hint_, cells_.size());
  for (const auto& cells : cells_) {
    archive(cells != nullptr);
    if (cells == nullptr) continue;
    archive(cells->grid.alphaCells(), cells->grid.betaCells());
    cells->store.save(archive);
  }
  waiting_.save(archive);
}

void LayerWriter::restore(const LtrPartition& partition, StateReader& archive) {
  archive(revision_, hint_);
  archive.require(hint_ == kNone || isIndex(hint_, partition.mesh().ltrEnd()),
                  "it wrote last into a triangle that is not there");
  cells_.clear();
  for (std::size_t left = archive.readSize(); left > 0; --left) {
    cells_.emplace_back();
    const bool is_there = archive.read<bool>();
    const auto ltr = static_cast<int>(cells_.size()) - 1;
    archive.require(
        ltr < partition.mesh().ltrEnd() && partition.mesh().ltr(ltr).is_alive == is_there,
        "a triangle has no cells, or cells have no triangle");
    if (!is_there) continue;
    const auto alpha = archive.read<int>(), beta = archive.read<int>();
    archive.require(alpha > 0 && beta > 0 && 1LL * alpha * beta <= kMostCells,
                    "a triangle has a grid that cannot be");
    cells_.back() = std::make_unique<LtrCells>(layers_, TriangularGrid(alpha, beta));
    cells_.back()->store.restore(layers_, archive);
  }
  archive.require(cells_.size() == std::size_t(partition.mesh().ltrEnd()),
                  "a triangle has no cells, or cells have no triangle");
  waiting_.restore(archive);
}

}  // namespace hymm::core
