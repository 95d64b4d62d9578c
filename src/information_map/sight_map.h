#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/config.h"
#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

/// What the dense map is asked for: what hides landmarks, and where the vehicle fits.
struct DenseMapConfig {
  bool occlusion = false;
  double occupied_probability = 0.6;
  double landmark_clearance_m = 0.7;
  bool unknown_is_free = true;

  void describe(ConfigSchema& schema);
};

/// One state of the dense map, as far as the information map needs it: along which lines a sensor
/// looks, and where the vehicle can be. What lies beyond the image is unknown. Immutable.
class SightMap {
 public:
  /// The image's cells are as many as its width and height say.
  SightMap(const DenseMapConfig& config, const OccupancyImage& image);

  /// Whether something solid stands between a sensor and the middle of a landmark. What is nearer
  /// to the landmark than landmark_clearance_m is taken for the landmark itself.
  bool hides(const Eigen::Vector2d& sensor, const Eigen::Vector2d& landmark) const;

  /// Whether nothing solid is within `clearance_m` of a place.
  bool isFree(const Eigen::Vector2d& place, double clearance_m) const;

  /// Middles of the cells that are occupied here and not in `other`. Null, or one of another
  /// resolution: of all cells that are occupied here.
  std::vector<Eigen::Vector2d> occupiedUnlike(const SightMap* other) const;

  double resolution_m() const { return resolution_m_; }

 private:
  enum class State : std::uint8_t { kUnknown, kFree, kOccupied };

  /// Of a cell, counted from the map's origin.
  State at(const Eigen::Vector2i& cell) const;
  Eigen::Vector2i cellAt(const Eigen::Vector2d& place) const;

  DenseMapConfig config_;
  double resolution_m_;
  Eigen::Vector2i corner_;
  int width_, height_;
  std::vector<State> states_;
};

}  // namespace hymm::core
