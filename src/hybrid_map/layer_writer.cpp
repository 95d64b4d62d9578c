#include "hybrid_map/layer_writer.h"

#include <algorithm>
#include <cmath>

#include "hybrid_map/log_odds.h"

namespace hymm::core {
namespace {

// Inputs for which cells stay unpacked after they were written: where sensors are far apart,
// nothing is packed and unpacked in turns.
constexpr std::uint64_t kIdleInputs = 100;

}  // namespace

LayerWriter::LayerWriter(const HybridMapConfig& config, const LayerSet& layers)
    : config_(config), layers_(layers), waiting_(config.waiting, layers, config.resolution_m) {}

void LayerWriter::begin(const Eigen::Vector2d& place, const LandmarkPlaces& landmarks,
                        std::uint64_t revision) {
  revision_ = revision;
  waiting_.select(place, landmarks);
}

std::optional<CellPlace> LayerWriter::cellInLtrs(const LtrPartition& partition,
                                                 const Eigen::Vector2d& place) {
  const int ltr = partition.mesh().locate(place, hint_);
  if (ltr == kNone) return std::nullopt;
  hint_ = ltr;
  LtrCells& cells = *cells_[std::size_t(ltr)];
  return CellPlace{&cells.store,
                   cells.grid.index(partition.mesh().ltr(ltr).triangle.toLocal(place))};
}

CellPlace LayerWriter::cellFor(LtrPartition& partition, const Eigen::Vector2d& place,
                               double share) {
  const auto cell = cellInLtrs(partition, place);
  if (!cell) return waiting_.cellAt(place, revision_);
  partition.addObservations(hint_, share);
  return *cell;
}

void LayerWriter::addSample(LtrPartition& partition, int layer, const Eigen::Vector2d& place,
                            const LayerSample& sample, double share) {
  const CellPlace cell = cellFor(partition, place, share);
  float* cells = cell.store->write(layers_, layer, revision_);
  layers_.model(layer).add(sample, share,
                           cells + std::ptrdiff_t{cell.index} * layers_.channels(layer));
}

/// Lets LTRs take what waited where they are now.
class LayerWriter::Settler : public WaitingTiles::Taker {
 public:
  Settler(LayerWriter& writer, LtrPartition& partition)
      : writer_(writer), partition_(partition), overlay_(writer.layers_, writer.revision_) {}

  void makeRoom(const CellPart& part, const Eigen::Vector2d& place) override {
    if (const auto cell = writer_.cellInLtrs(partition_, place)) overlay_.makeRoom(part, *cell);
  }
  bool take(const CellPart& part, const Eigen::Vector2d& place) override {
    const auto cell = writer_.cellInLtrs(partition_, place);
    if (!cell) return false;
    overlay_.add(part, *cell);
    partition_.addObservations(writer_.hint_, static_cast<double>(part.share));
    return true;
  }
  void finish() override { overlay_.finish(); }

 private:
  LayerWriter& writer_;
  LtrPartition& partition_;
  CellOverlay overlay_;
};

void LayerWriter::follow(LtrPartition& partition, const PartitionChange& change,
                         const LandmarkPlaces& landmarks, std::uint64_t revision) {
  revision_ = revision;
  waiting_.follow(landmarks);
  cells_.resize(std::size_t(partition.mesh().ltrEnd()));
  std::vector<WaitingTiles::Box> boxes;
  for (const int ltr : change.created) {
    const Triangle& triangle = partition.mesh().ltr(ltr).triangle;
    cells_[std::size_t(ltr)] = std::make_unique<LtrCells>(layers_, triangle, config_.resolution_m);
    const Corners corners = partition.mesh().corners(ltr);
    boxes.push_back({corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
                     corners[0].cwiseMax(corners[1]).cwiseMax(corners[2])});
  }
  for (const RetiredLtr& retired : change.retired) moveRetired(partition, retired, landmarks);
  if (boxes.empty() || waiting_.isEmpty()) return;
  Settler settler(*this, partition);
  waiting_.settle(boxes, settler);
}

void LayerWriter::moveRetired(LtrPartition& partition, const RetiredLtr& retired,
                              const LandmarkPlaces& landmarks) {
  const std::unique_ptr<LtrCells> cells = std::move(cells_[std::size_t(retired.ltr)]);
  if (cells == nullptr) return;
  const Eigen::Vector2d centre = retired.last_valid.toGlobal(Triangle::Local::Constant(1.0 / 3.0));
  waiting_.select(retired.T_map_last_valid * centre, landmarks);
  const auto visitParts = [&](auto&& visit) {
    visitCells(*cells, layers_, [&](int layer, int index, const auto& parts, std::size_t count) {
      const CellPart part = partOf(layers_, cells->store, layer, index, count);
      for (std::size_t i = 0; i < count; ++i) {
        visit(part, retired.T_map_last_valid * retired.last_valid.toGlobal(parts[i]));
      }
    });
  };
  CellOverlay overlay(layers_, revision_);
  visitParts([&](const CellPart& part, const Eigen::Vector2d& place) {
    if (!layers_.model(part.layer).hasLimits()) return;
    overlay.makeRoom(part, cellFor(partition, place, 0.0));
  });
  visitParts([&](const CellPart& part, const Eigen::Vector2d& place) {
    overlay.add(part, cellFor(partition, place, static_cast<double>(part.share)));
  });
  overlay.finish();
}

double LayerWriter::evidence(int layer) const {
  double sum = 0.0;
  for (const auto& cells : cells_) {
    if (cells == nullptr || cells->store.isEmpty(layer)) continue;
    for (int cell = 0; cell < cells->store.cellCount(); ++cell) {
      sum += layers_.model(layer).evidence(cells->store.read(layers_, layer, cell));
    }
  }
  return sum;
}

CellMemory LayerWriter::memory() const {
  CellMemory memory;
  for (const auto& cells : cells_) {
    if (cells != nullptr) cells->store.addMemory(memory);
  }
  return memory;
}

void LayerWriter::packBeyond(const LtrPartition& partition, const Eigen::Vector2d& vehicle) {
  const std::uint64_t since = revision_ > kIdleInputs ? revision_ - kIdleInputs : 0;
  const double radius_m = config_.active_radius_m;
  const auto threshold = static_cast<float>(logOddsOf(config_.compression.occupied_probability));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if (cells_[i] == nullptr) continue;
    const Corners corners = partition.mesh().corners(static_cast<int>(i));
    const bool is_near = std::any_of(corners.begin(), corners.end(), [&](const auto& corner) {
      return (corner - vehicle).norm() <= radius_m;
    });
    if (is_near) continue;
    CellStore& store = cells_[i]->store;
    if (config_.compression.isLossy()) store.packOccupancy(cells_[i]->grid, threshold, since);
    store.pack(since);
  }
  waiting_.packBeyond(vehicle, radius_m, since);
}

std::size_t LayerWriter::forgetBeyondLimit(LtrPartition& partition) {
  constexpr double kBytesPerMb = 1e6;
  const double limit = config_.max_memory_mb * kBytesPerMb;
  double used = static_cast<double>(memory().bytes());
  if (used <= limit) return 0;
  const auto memoryOf = [&](int ltr) {
    CellMemory memory;
    find(ltr)->store.addMemory(memory);
    return memory;
  };
  std::vector<int> far;
  for (int ltr = 0; ltr < static_cast<int>(cells_.size()); ++ltr) {
    const bool is_written = find(ltr) != nullptr && partition.mesh().ltr(ltr).observations > 0.0;
    if (is_written && memoryOf(ltr).unpacked_bytes == 0) far.push_back(ltr);
  }
  std::sort(far.begin(), far.end(), [&](int one, int other) {
    return find(one)->store.lastRevision() < find(other)->store.lastRevision();
  });
  std::size_t forgotten = 0;
  for (const int ltr : far) {
    if (used <= limit) break;
    used -= static_cast<double>(memoryOf(ltr).bytes());
    cells_[std::size_t(ltr)]->store.forget(revision_);
    used += static_cast<double>(memoryOf(ltr).bytes());
    partition.addObservations(ltr, -partition.mesh().ltr(ltr).observations);
    ++forgotten;
  }
  return forgotten;
}

}  // namespace hymm::core
