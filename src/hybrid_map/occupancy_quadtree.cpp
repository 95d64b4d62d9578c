#include "hybrid_map/occupancy_quadtree.h"

#include <algorithm>

namespace hymm::core {
namespace {

enum Node : std::uint8_t { kUnknown, kFree, kOccupied, kSplit, kOutside };

Node kindOf(float log_odds, float threshold) {
  if (log_odds == 0.0F) return kUnknown;
  return log_odds > threshold ? kOccupied : kFree;
}

/// The side of the square of 2^n cells that covers a grid.
int edgeOver(const TriangularGrid& grid) {
  int edge = 1;
  while (edge < std::max(grid.alphaCells(), grid.betaCells())) edge *= 2;
  return edge;
}

/// Rows get shorter upwards: where the least cell of a square is outside, all of it is.
bool isOutside(const TriangularGrid& grid, int x, int y) {
  return y >= grid.betaCells() || x >= grid.rowLength(y);
}

/// Nodes of the tree over a grid, parents before their children.
class Encoder {
 public:
  Encoder(const TriangularGrid& grid, const std::vector<float>& log_odds, float threshold)
      : grid_(grid), log_odds_(log_odds), threshold_(threshold) {
    encode(0, 0, edgeOver(grid));
  }

  /// Four nodes to a byte.
  std::vector<std::uint8_t> packed() const {
    std::vector<std::uint8_t> bytes((nodes_.size() + 3) / 4, 0);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      bytes[i / 4] = static_cast<std::uint8_t>(bytes[i / 4] | (nodes_[i] << (2 * (i % 4))));
    }
    return bytes;
  }

 private:
  /// Appends the nodes of a square; returns its kind, kSplit if its cells are of several. What lies
  /// outside of the triangle joins with anything.
  Node encode(int x, int y, int edge) {
    const std::size_t start = nodes_.size();
    nodes_.push_back(kSplit);
    const Node kind = kindOfSquare(x, y, edge);
    if (kind == kSplit) return kind;
    nodes_.resize(start + 1);
    nodes_[start] = kind == kOutside ? kUnknown : kind;
    return kind;
  }

  Node kindOfSquare(int x, int y, int edge) {
    if (isOutside(grid_, x, y)) return kOutside;
    if (edge == 1) {
      return kindOf(log_odds_[static_cast<std::size_t>(grid_.index(x, y))], threshold_);
    }
    const int half = edge / 2;
    Node kind = kOutside;
    for (int child = 0; child < 4; ++child) {
      kind = joined(kind, encode(x + (child & 1) * half, y + (child >> 1) * half, half));
    }
    return kind;
  }

  static Node joined(Node one, Node other) {
    if (one == kOutside) return other;
    return other == kOutside || other == one ? one : kSplit;
  }

  const TriangularGrid& grid_;
  const std::vector<float>& log_odds_;
  float threshold_;
  std::vector<std::uint8_t> nodes_;
};

/// Writes the value of each node into the cells under it.
class Decoder {
 public:
  Decoder(const TriangularGrid& grid, const std::vector<std::uint8_t>& nodes,
          const std::array<float, 3>& log_odds)
      : grid_(grid), nodes_(nodes), log_odds_(log_odds) {
    cells_.resize(static_cast<std::size_t>(grid.cellCount()));
    decode(0, 0, edgeOver(grid));
  }

  std::vector<float> take() { return std::move(cells_); }

 private:
  void decode(int x, int y, int edge) {
    const int node = (nodes_[next_ / 4] >> (2 * (next_ % 4))) & 3;
    ++next_;
    if (node == kSplit) {
      const int half = edge / 2;
      for (int child = 0; child < 4; ++child) {
        decode(x + (child & 1) * half, y + (child >> 1) * half, half);
      }
      return;
    }
    for (int row = y; row < std::min(y + edge, grid_.betaCells()); ++row) {
      const int end = std::min(x + edge, grid_.rowLength(row));
      if (end <= x) return;
      std::fill_n(cells_.begin() + grid_.index(x, row), end - x,
                  log_odds_[static_cast<std::size_t>(node)]);
    }
  }

  const TriangularGrid& grid_;
  const std::vector<std::uint8_t>& nodes_;
  const std::array<float, 3>& log_odds_;
  std::size_t next_ = 0;
  std::vector<float> cells_;
};

/// Means of unknown, free and occupied cells.
std::array<float, 3> meansOf(const std::vector<float>& log_odds, float threshold) {
  std::array<double, 3> sums{};
  std::array<std::size_t, 3> counts{};
  for (const float value : log_odds) {
    const Node kind = kindOf(value, threshold);
    sums[kind] += static_cast<double>(value);
    ++counts[kind];
  }
  std::array<float, 3> means{};
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (counts[i] > 0) means[i] = static_cast<float>(sums[i] / static_cast<double>(counts[i]));
  }
  return means;
}

}  // namespace

OccupancyQuadtree::OccupancyQuadtree(const TriangularGrid& grid, const std::vector<float>& log_odds,
                                     float threshold)
    : alpha_cells_(grid.alphaCells()),
      beta_cells_(grid.betaCells()),
      log_odds_(meansOf(log_odds, threshold)),
      nodes_(Encoder(grid, log_odds, threshold).packed()) {}

std::vector<float> OccupancyQuadtree::unpack() const {
  return Decoder(TriangularGrid(alpha_cells_, beta_cells_), nodes_, log_odds_).take();
}

std::size_t OccupancyQuadtree::bytes() const { return nodes_.capacity(); }

std::size_t OccupancyQuadtree::unpackedBytes() const {
  if (isEmpty()) return 0;
  const auto cells =
      static_cast<std::size_t>(TriangularGrid(alpha_cells_, beta_cells_).cellCount());
  return cells * sizeof(float);
}

}  // namespace hymm::core
