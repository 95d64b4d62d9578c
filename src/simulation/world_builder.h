#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/random.h"
#include "simulation/world.h"
#include "vehicle/vehicle_config.h"

namespace hymm::core {

/// Puts things into a world so that nothing stands in the way of what drives there, and nothing
/// stands in anything else.
class WorldBuilder {
 public:
  /// Free space that stays between the vehicle on its route and anything solid.
  static constexpr double kMargin_m = 0.5;

  /// The vehicle's body, driven along `route`, is kept clear.
  WorldBuilder(Route route, double speed_mps, const VehicleConfig& vehicle);

  /// Adds the solid if its place is free by `spacing_m`. Returns whether it was added.
  bool tryAdd(const Shape& shape, const Material& material, double spacing_m);

  /// Adds a disc that is a landmark, likewise.
  bool tryAddLandmark(LandmarkType type, const Eigen::Vector2d& position, double diameter_m,
                      double spacing_m);

  /// Adds a car that drives along `path`, and keeps its way clear for the things added later.
  void addMovingCar(const Route& path, double speed_mps, double start_m);

  /// Adds a person who walks to and fro between two points if the way is free.
  bool tryAddPerson(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double speed_mps);

  /// Distance from the route, up to `limit_m`.
  double distanceFromRoute(const Eigen::Vector2d& point, double limit_m) const;

  /// What all of it stands on; level if it is not told.
  void setTerrain(Terrain terrain) { world_.terrain = std::move(terrain); }

  const Route& route() const { return world_.route; }
  std::size_t landmarkCount() const { return world_.landmarks.size(); }
  World take() { return std::move(world_); }

 private:
  /// Buckets of indices by place.
  class Buckets {
   public:
    void add(const Eigen::AlignedBox2d& bounds, std::size_t index);
    /// Calls `visit(index)`, some more than once, until it returns true; returns whether it did.
    template <class Visitor>
    bool any(const Eigen::AlignedBox2d& bounds, Visitor visit) const;

   private:
    std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
  };

  void keepClear(const Route& route, const Polygon& body);
  bool isFree(const Shape& shape, double spacing_m) const;

  World world_;
  std::vector<Disc> clear_;  ///< where nothing may stand
  Buckets clear_buckets_, solid_buckets_, route_buckets_;
};

}  // namespace hymm::core
