#pragma once

#include <functional>
#include <vector>

#include "common/random.h"
#include "perception/laser_scan.h"
#include "simulation/beam_plane.h"
#include "simulation/ray_caster.h"
#include "simulation/simulation_config.h"
#include "simulation/world.h"

namespace hymm::core {

/// The solid world at one moment: what stands, and what moves where it is now.
class Scene {
 public:
  /// `standing`, its caster and `terrain` (level ground if there is none) outlive the scene. What
  /// is solid is taller than any beam climbs.
  Scene(const std::vector<Solid>& standing, const RayCaster& standing_caster,
        std::vector<Solid> moving, const Terrain* terrain = nullptr);

  struct Hit {
    double range_m;
    double incidence_cosine;
    const Solid* solid;
  };
  /// The nearest hit within `range_max_m` along the beam.
  std::optional<Hit> cast(const Beam& beam, double range_max_m) const;

 private:
  const std::vector<Solid>& standing_;
  const RayCaster& standing_caster_;
  std::vector<Solid> moving_;
  RayCaster moving_caster_;
  const Terrain* terrain_;
};

struct SimulatedScan {
  LaserScan scan;
  std::vector<int> beam_landmarks;  ///< what each beam truly met first, or -1
};

/// What a laser has before it at one moment.
struct LaserView {
  Scene scene;
  std::vector<Disc> reflectors;  ///< places of retro-reflecting discs near the sensor
  BeamPlane plane;
};

/// A planar laser with the errors of real ones. Its beams are cast at one instant, or one after
/// another if it rotates.
class SimulatedLaser {
 public:
  SimulatedLaser(const SimulatedLaserConfig& config, RandomGenerator generator);

  /// What there is to see at any moment of a scan.
  using View = std::function<LaserView(double time_s)>;

  /// `time_s`: of the first beam.
  SimulatedScan scan(const View& view, double time_s);

  /// From the first beam of a scan to the last.
  double sweep_s() const { return sweep_s_; }

 private:
  using Hit = std::optional<Scene::Hit>;

  /// Beams that count as cast at the same moment, from the first to behind the last.
  struct Group {
    std::size_t first, end;
  };

  LaserScan emptyScan(double time_s) const;
  void cast(const LaserView& view, const Group& group, SimulatedScan& result);
  void widenReflectors(const LaserView& view, const LaserScan& scan, const Group& group,
                       std::vector<Hit>& hits) const;
  bool isReturned(const Scene::Hit& hit);
  double mixedRange(const Scene& scene, const BeamPlane& plane, double bearing_rad, double range_m);
  double measuredRange(double range_m, double roughness_m);
  float intensity(const Hit& hit);
  float reported(double range_m) const;

  SimulatedLaserConfig config_;
  RandomGenerator generator_;
  double sweep_s_;
};

}  // namespace hymm::core
