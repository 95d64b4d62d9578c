#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/colour.h"

namespace hymm::core {

/// One layer of one LTR as it is told (see msg/LtrGrid.msg).
struct ToldLayer {
  std::string layer, model;
  long long alpha_cells = 0, beta_cells = 0, channels = 0;
};

/// What a layer says in each of its cells.
struct LayerField {
  enum class Kind { kOccupancy, kValue, kCategory };
  Kind kind = Kind::kOccupancy;
  int alpha_cells = 0, beta_cells = 0;
  /// Probability, value or index of the likeliest category; NaN where nothing is known. Rows of
  /// the LTR's triangular grid, one after another.
  std::vector<float> values;
};

/// Cells along a side at most, so that a grid fits a texture with its rim.
constexpr int kMostCellsAlong = 2046;

/// Reads a layer; nothing, with a sentence in `problem`, if it does not fit its description.
std::optional<LayerField> readLayer(const ToldLayer& told, const std::vector<float>& cells,
                                    std::string& problem);

/// Lowest and highest of values; empty while `low` > `high`.
struct ValueRange {
  double low = 1.0, high = 0.0;

  bool isEmpty() const { return low > high; }
  /// Whether it grew.
  bool include(const LayerField& field);
};

/// An image of a layer: `width` x `height` pixels, row by row, one for each cell and a rim around
/// them one pixel wide that repeats what is next to it, as does the half beyond the triangle: what
/// is drawn at the triangle's border never mixes with what is not its own. Nothing known:
/// transparent.
struct LayerImage {
  int width = 0, height = 0;
  std::vector<Pixel> pixels;

  const Pixel& at(int x, int y) const {
    return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)];
  }
};

/// `range` is that of values other than occupancy and categories.
LayerImage paint(const LayerField& field, const ValueRange& range);

}  // namespace hymm::core
