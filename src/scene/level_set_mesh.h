#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/flat_mesh.h"

namespace hymm::core {

/// A square of a level set, of the island with this id.
struct ShownLeaf {
  double x_m = 0.0, y_m = 0.0, edge_m = 0.0;
  int island = -1;
};

/// Why leaves cannot be drawn; nothing if they can: finite centres and edges over 0.
std::optional<std::string> problemWith(const std::vector<ShownLeaf>& leaves);

/// The colour of an island in a set whose value is number `rank` (0 the lowest) of `ranks`: its hue
/// tells the island, its brightness the value.
Colour levelSetColour(int island, int rank, int ranks);

/// Two triangles for each leaf.
FlatVertices levelSetTriangles(const std::vector<ShownLeaf>& leaves, int rank, int ranks,
                               float alpha);

}  // namespace hymm::core
