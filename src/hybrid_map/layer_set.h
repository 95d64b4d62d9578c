#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hybrid_map/cell_model.h"

namespace hymm::core {

/// The layers of a map, by number. Layer 0 is the occupancy.
class LayerSet {
 public:
  static constexpr int kOccupancy = 0;

  /// `description`: entries "NAME MODEL WORD…" separated by semicolons, as in
  ///   "height gaussian; terrain category grass asphalt; traffic rate dry wet".
  /// Adds a sentence to `problems` for each entry that cannot be used.
  LayerSet(const std::string& description, int day_parts, std::vector<std::string>& problems,
           const LogOddsLimits& occupancy_limits = {});

  int count() const { return static_cast<int>(layers_.size()); }
  const std::string& name(int layer) const { return layers_[std::size_t(layer)].name; }
  const CellModel& model(int layer) const { return *layers_[std::size_t(layer)].model; }
  /// The cell model and its words, as the description has them: "category grass asphalt".
  const std::string& modelText(int layer) const { return layers_[std::size_t(layer)].model_text; }
  int channels(int layer) const { return layers_[std::size_t(layer)].channels; }
  /// Floats of a cell in all layers together.
  int channelsTogether() const;
  /// The layer's number, or -1.
  int find(const std::string& name) const;
  std::vector<std::string> names() const;

 private:
  struct Layer {
    std::string name;
    std::string model_text;
    std::unique_ptr<CellModel> model;
    int channels;
  };
  void add(const std::string& name, const std::string& model_text,
           std::unique_ptr<CellModel> model);

  std::vector<Layer> layers_;
};

}  // namespace hymm::core
