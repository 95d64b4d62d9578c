#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "common/config.h"
#include "hybrid_map/hybrid_map.h"
#include "hybrid_map/image_tiles.h"
#include "hybrid_map/occupancy_image.h"

namespace hymm::core {

struct MapImageConfig {
  double resolution_m = 0.2;
  double redraw_shift_cells = 0.25;
  bool include_waiting = true;
  double max_memory_mb = 400.0;

  void describe(ConfigSchema& schema);
};

/// What an update changed. The patches do not overlap and hold all cells that changed; where the
/// image was resized, the whole of it is new.
struct ImageChange {
  bool is_resized = false;
  std::vector<ImagePatch> patches;

  bool isEmpty() const { return !is_resized && patches.empty(); }
};

/// The occupancy of a hybrid map as an image that follows it: LTRs are walked and drawn where they
/// are now, but only where something was written, or moved, since the last update. A cell shows
/// what is known at its middle, or an occupied cell of an LTR whose middle lies in it: none gets
/// lost. Where no LTR knows anything, what waits for one is drawn. The image grows with the map and
/// does not shrink.
///
///   MapImage image(config);
///   const ImageChange change = image.update(map);  // as often as the image is wanted
class MapImage {
 public:
  /// Throws ConfigError if the configuration is unusable.
  explicit MapImage(const MapImageConfig& config);

  /// Draws what changed: costs by the area that changed, and a glance at each LTR.
  ImageChange update(const HybridMap& map);

  const OccupancyImage& image() const { return image_; }

  /// Whether the last update left out a part of the map, because the image may not grow further.
  bool isCutOff() const { return is_cut_off_; }

 private:
  /// How an LTR, or a tile of what waits, was drawn last.
  struct Drawn {
    ConvexRegion region{};
    std::uint64_t revision = 0;  ///< 0: it was not
    std::uint64_t update = 0;    ///< that saw it last
  };
  using WaitingKey = std::tuple<std::uint64_t, int, int>;  ///< sheet, place

  void look(Drawn& drawn, const ConvexRegion& region, std::uint64_t revision);
  void forget(Drawn& drawn);
  void findChangedLtrs(const HybridMap& map);
  void findChangedWaiting(const HybridMap& map);
  bool grow();
  void clear(const ImageTiles& tiles);
  void drawWaiting(const HybridMap& map, const ImageTiles& tiles);
  void drawLtrs(const HybridMap& map, const ImageTiles& tiles);

  MapImageConfig config_;
  OccupancyImage image_;
  std::vector<Drawn> ltrs_;
  std::map<WaitingKey, Drawn> waiting_;
  std::vector<ConvexRegion> changed_;  ///< regions since the last update
  Eigen::Array2d low_, high_;          ///< box of everything that is known [m]
  std::uint64_t updates_ = 0;
  bool is_cut_off_ = false;
};

}  // namespace hymm::core
