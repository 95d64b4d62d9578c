#include "scene/level_set_mesh.h"

#include <cmath>

namespace hymm::core {
namespace {

constexpr float kDarkest = 0.55F;  // of the lowest value, so that its hue is still seen

}  // namespace

std::optional<std::string> problemWith(const std::vector<ShownLeaf>& leaves) {
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const ShownLeaf& leaf = leaves[i];
    if (std::isfinite(leaf.x_m) && std::isfinite(leaf.y_m) && std::isfinite(leaf.edge_m) &&
        leaf.edge_m > 0.0) {
      continue;
    }
    return "leaf " + std::to_string(i) + " has a centre or an edge that no square can have";
  }
  return std::nullopt;
}

Colour levelSetColour(int island, int rank, int ranks) {
  Colour colour = distinctColour(island);
  const float share = ranks > 1 ? static_cast<float>(rank) / static_cast<float>(ranks - 1) : 1.0F;
  const float brightness = kDarkest + share * (1.0F - kDarkest);
  colour.red *= brightness;
  colour.green *= brightness;
  colour.blue *= brightness;
  return colour;
}

FlatVertices levelSetTriangles(const std::vector<ShownLeaf>& leaves, int rank, int ranks,
                               float alpha) {
  FlatVertices vertices;
  vertices.positions.reserve(6 * leaves.size());
  vertices.colours.reserve(6 * leaves.size());
  for (const ShownLeaf& leaf : leaves) {
    Colour colour = levelSetColour(leaf.island, rank, ranks);
    colour.alpha = alpha;
    const Pixel pixel = pixelOf(colour);
    const double half = 0.5 * leaf.edge_m;
    const auto corner = [&](double x, double y) {
      vertices.add({leaf.x_m + x * half, leaf.y_m + y * half}, pixel);
    };
    corner(-1, -1), corner(1, -1), corner(1, 1);
    corner(-1, -1), corner(1, 1), corner(-1, 1);
  }
  return vertices;
}

}  // namespace hymm::core
