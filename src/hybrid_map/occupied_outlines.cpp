#include "hybrid_map/occupied_outlines.h"

#include <array>
#include <cstdint>
#include <utility>

#include "hybrid_map/map_export.h"

namespace hymm::core {
namespace {

constexpr int kEmpty = -1;

/// Along x, y, against x, against y: turning left counts up.
const std::array<Eigen::Vector2i, 4> kDirections = {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1),
                                                    Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)};

/// The island of each cell: occupied cells that hang together by their sides.
class Islands {
 public:
  explicit Islands(const OccupancyImage& image)
      : width_(image.width), height_(image.height), island_(image.cells.size(), kEmpty) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (at(x, y) == kEmpty && isOccupied(image, x, y)) fill(image, x, y);
      }
    }
  }

  int count() const { return count_; }
  int at(int x, int y) const {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return kEmpty;
    return island_[std::size_t(y) * std::size_t(width_) + std::size_t(x)];
  }

 private:
  static bool isOccupied(const OccupancyImage& image, int x, int y) {
    return trinaryOccupancy(image.at(x, y)) > 0;
  }

  void fill(const OccupancyImage& image, int first_x, int first_y) {
    std::vector<Eigen::Vector2i> open = {{first_x, first_y}};
    const auto take = [&](int x, int y) {
      if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
      int& island = island_[std::size_t(y) * std::size_t(width_) + std::size_t(x)];
      if (island != kEmpty || !isOccupied(image, x, y)) return;
      island = count_;
      open.emplace_back(x, y);
    };
    island_[image.index(first_x, first_y)] = count_;
    while (!open.empty()) {
      const Eigen::Vector2i cell = open.back();
      open.pop_back();
      for (const Eigen::Vector2i& step : kDirections)
        take(cell.x() + step.x(), cell.y() + step.y());
    }
    ++count_;
  }

  int width_, height_;
  std::vector<int> island_;
  int count_ = 0;
};

/// Walks along the border of an island with the island to the left.
class BorderWalk {
 public:
  BorderWalk(const Islands& islands, int width, int height)
      : islands_(islands), width_(width), walked_(std::size_t(width) * std::size_t(height), 0) {}

  /// Whether the lower side of a cell is a border that no ring has.
  bool isNew(int x, int y) const {
    return islands_.at(x, y) != islands_.at(x, y - 1) && walked_[index(x, y)] == 0;
  }

  /// The ring that runs along the lower side of a cell.
  CellRing ring(int x, int y) {
    const int island = islands_.at(x, y);
    const Eigen::Vector2i start(x, y);
    CellRing corners;
    Eigen::Vector2i at = start;
    int direction = 0;
    do {
      if (direction == 0) walked_[index(at.x(), at.y())] = 1;
      at += kDirections[std::size_t(direction)];
      const int next = turnAt(at, direction, island);
      if (next != direction) corners.push_back(at);
      direction = next;
    } while (at != start || direction != 0);
    return corners;
  }

 private:
  /// Where two cells of the island touch in a corner, the border turns right: it keeps to the
  /// empty cells that it has followed.
  int turnAt(const Eigen::Vector2i& at, int direction, int island) const {
    const bool left = islandAhead(at, direction, true) == island;
    const bool right = islandAhead(at, direction, false) == island;
    if (right) return (direction + 3) % 4;
    return left ? direction : (direction + 1) % 4;
  }

  /// Of the cell ahead of a corner, to the left or to the right of the way.
  int islandAhead(const Eigen::Vector2i& at, int direction, bool left) const {
    // Corners of cells around a corner: ahead left of x is (0, 0), of y (-1, 0), and so on.
    static const std::array<Eigen::Vector2i, 4> around = {
        Eigen::Vector2i(0, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(-1, -1),
        Eigen::Vector2i(0, -1)};
    const Eigen::Vector2i cell = at + around[std::size_t(left ? direction : (direction + 3) % 4)];
    return islands_.at(cell.x(), cell.y());
  }

  std::size_t index(int x, int y) const {
    return std::size_t(y) * std::size_t(width_) + std::size_t(x);
  }

  const Islands& islands_;
  int width_;
  std::vector<std::uint8_t> walked_;  ///< by cell: its lower side
};

/// Twice the area; negative where it runs clockwise.
long long doubleArea(const CellRing& ring) {
  long long sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2i &a = ring[i], &b = ring[(i + 1) % ring.size()];
    sum += 1LL * a.x() * b.y() - 1LL * b.x() * a.y();
  }
  return sum;
}

}  // namespace

std::vector<CellPolygon> occupiedOutlines(const OccupancyImage& image) {
  const Islands islands(image);
  std::vector<CellPolygon> polygons(std::size_t(islands.count()));
  BorderWalk walk(islands, image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int island = islands.at(x, y);
      if (island == kEmpty || !walk.isNew(x, y)) continue;
      CellRing ring = walk.ring(x, y);
      const bool is_outline = doubleArea(ring) > 0;
      for (Eigen::Vector2i& corner : ring) corner += image.corner;
      CellPolygon& polygon = polygons[std::size_t(island)];
      if (is_outline) {
        polygon.outline = std::move(ring);
      } else {
        polygon.holes.push_back(std::move(ring));
      }
    }
  }
  return polygons;
}

}  // namespace hymm::core
