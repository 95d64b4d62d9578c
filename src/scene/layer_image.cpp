#include "scene/layer_image.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>

#include "hybrid_map/layer_set.h"
#include "hybrid_map/triangular_grid.h"

namespace hymm::core {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr int kMostDayParts = 24;

/// The cell model of a told layer, as the only one of a set (but for its occupancy).
struct ToldModel {
  LayerSet layers;
  int number;

  const CellModel& model() const { return layers.model(number); }
};

std::optional<ToldModel> modelOf(const ToldLayer& told, std::string& problem) {
  std::istringstream words(told.model);
  std::string kind;
  words >> kind;
  // The parts of the day are not told, but follow from the number of channels.
  const auto weathers = std::distance(std::istream_iterator<std::string>(words), {});
  const long long classes = told.channels / 2;
  const long long day_parts = classes / (2 * std::max<long long>(1, weathers));
  std::vector<std::string> problems;
  ToldModel result{
      LayerSet(kind == "occupancy" ? "" : "layer " + told.model,
               static_cast<int>(std::clamp<long long>(day_parts, 1, kMostDayParts)), problems),
      kind == "occupancy" ? 0 : 1};
  if (result.layers.count() != result.number + 1) {
    problem = "layer '" + told.layer + "' has the cell model '" + told.model +
              "', which is not known here";
    return std::nullopt;
  }
  if (result.model().channels() != told.channels) {
    problem = "layer '" + told.layer + "' has " + std::to_string(told.channels) +
              " numbers a cell, but its model '" + told.model + "' has " +
              std::to_string(result.model().channels());
    return std::nullopt;
  }
  return result;
}

LayerField::Kind kindOf(const std::string& model) {
  if (model.rfind("occupancy", 0) == 0) return LayerField::Kind::kOccupancy;
  if (model.rfind("category", 0) == 0) return LayerField::Kind::kCategory;
  return LayerField::Kind::kValue;
}

bool fits(const ToldLayer& told, std::size_t numbers, std::string& problem) {
  const auto isSide = [](long long cells) { return cells >= 1 && cells <= kMostCellsAlong; };
  if (!isSide(told.alpha_cells) || !isSide(told.beta_cells)) {
    problem = "layer '" + told.layer + "' has " + std::to_string(told.alpha_cells) + " x " +
              std::to_string(told.beta_cells) + " cells, 1 to " + std::to_string(kMostCellsAlong) +
              " along a side can be drawn";
    return false;
  }
  const TriangularGrid grid(static_cast<int>(told.alpha_cells), static_cast<int>(told.beta_cells));
  const long long wanted = grid.cellCount() * told.channels;
  if (static_cast<long long>(numbers) == wanted) return true;
  problem = "layer '" + told.layer + "' has " + std::to_string(numbers) + " numbers, but its " +
            std::to_string(told.alpha_cells) + " x " + std::to_string(told.beta_cells) +
            " cells of " + std::to_string(told.channels) + " take " + std::to_string(wanted);
  return false;
}

Pixel pixelFor(const LayerField& field, float value, const ValueRange& range) {
  if (!std::isfinite(value)) return {0, 0, 0, 0};
  switch (field.kind) {
    case LayerField::Kind::kOccupancy:
      return pixelOf(occupancyColour(static_cast<double>(value)));
    case LayerField::Kind::kCategory:
      return pixelOf(distinctColour(static_cast<int>(value)));
    case LayerField::Kind::kValue:
      break;
  }
  const double width = range.high - range.low;
  return pixelOf(rampColour(width > 0.0 ? (static_cast<double>(value) - range.low) / width : 0.5));
}

}  // namespace

std::optional<LayerField> readLayer(const ToldLayer& told, const std::vector<float>& cells,
                                    std::string& problem) {
  const std::optional<ToldModel> model = modelOf(told, problem);
  if (!model || !fits(told, cells.size(), problem)) return std::nullopt;
  LayerField field;
  field.kind = kindOf(told.model);
  field.alpha_cells = static_cast<int>(told.alpha_cells);
  field.beta_cells = static_cast<int>(told.beta_cells);
  const auto channels = static_cast<std::size_t>(told.channels);
  field.values.reserve(cells.size() / channels);
  for (std::size_t i = 0; i < cells.size(); i += channels) {
    const std::optional<LayerValue> value = model->model().read(&cells[i]);
    field.values.push_back(value ? static_cast<float>(value->value) : kUnknown);
  }
  return field;
}

bool ValueRange::include(const LayerField& field) {
  if (field.kind != LayerField::Kind::kValue) return false;
  const ValueRange before = *this;
  for (const float value : field.values) {
    if (!std::isfinite(value)) continue;
    const auto v = static_cast<double>(value);
    low = isEmpty() ? v : std::min(low, v);
    high = std::max(high, v);
  }
  return low != before.low || high != before.high;
}

LayerImage paint(const LayerField& field, const ValueRange& range) {
  const TriangularGrid grid(field.alpha_cells, field.beta_cells);
  LayerImage image;
  image.width = field.alpha_cells + 2;
  image.height = field.beta_cells + 2;
  image.pixels.reserve(std::size_t(image.width) * std::size_t(image.height));
  for (int y = 0; y < image.height; ++y) {
    const int row = std::clamp(y - 1, 0, field.beta_cells - 1);
    const int length = grid.rowLength(row);
    for (int x = 0; x < image.width; ++x) {
      const int column = x - 1;
      // Beyond the end of the row, once more what is at its end.
      const bool known = column >= 0 && column < length;
      if (!known && x > 0) {
        image.pixels.push_back(image.pixels.back());
      } else {
        const auto cell = std::size_t(grid.index(std::max(column, 0), row));
        image.pixels.push_back(pixelFor(field, field.values[cell], range));
      }
    }
  }
  return image;
}

}  // namespace hymm::core
