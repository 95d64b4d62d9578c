#include "simulation/simulation.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "simulation/occupancy.h"
#include "simulation/simulated_detector.h"
#include "simulation/simulated_gps.h"
#include "simulation/simulated_laser.h"
#include "simulation/simulated_vehicle.h"
#include "simulation/world_catalog.h"

namespace hymm::core {
namespace {

// Each part has a random stream of its own, so that changing one sensor leaves the others' errors
// as they were.
enum class Stream : std::uint32_t { kWorld, kVehicle, kLaser, kDetector, kGps, kAltimeter };

RandomGenerator makeGenerator(std::uint64_t seed, Stream stream) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                         static_cast<std::uint32_t>(stream)};
  return RandomGenerator(sequence);
}

/// Instants at an even rate, counted so that they do not drift.
class Clock {
 public:
  Clock(bool enabled, double rate_hz) : enabled_(enabled), rate_hz_(rate_hz) {}
  double next_s() const {
    if (!enabled_) return std::numeric_limits<double>::infinity();
    return Simulation::kStartTime_s + static_cast<double>(ticks_) / rate_hz_;
  }
  void advance() { ++ticks_; }

 private:
  bool enabled_;
  double rate_hz_;
  std::int64_t ticks_ = 0;
};

World worldFor(const SimulationConfig& config, const VehicleConfig& vehicle, std::uint64_t seed) {
  const std::uint64_t world_seed =
      config.world.seed >= 0 ? static_cast<std::uint64_t>(config.world.seed) : seed;
  RandomGenerator generator = makeGenerator(world_seed, Stream::kWorld);
  return makeWorld(config.world, vehicle, generator);
}

}  // namespace

struct Simulation::State {
  State(const SimulationConfig& c, const VehicleConfig& v, const World& world_enu,
        std::uint64_t seed)
      : config(c),
        vehicle_config(v),
        T_enu_map(world_enu.route.at(0.0)),
        world(world_enu.transformed(inverse(T_enu_map))),
        caster(world.solids),
        vehicle(v, c.motion, c.drive, world.route, world.speed_mps,
                makeGenerator(seed, Stream::kVehicle), world.terrain),
        laser(c.laser, makeGenerator(seed, Stream::kLaser)),
        detector(c.detections, makeGenerator(seed, Stream::kDetector)),
        gps(c.gps, makeGenerator(seed, Stream::kGps), kStartTime_s),
        altimeter(makeGenerator(seed, Stream::kAltimeter)),
        motion_clock(true, c.motion.rate_hz),
        scan_clock(c.laser.enabled, c.laser.rate_hz),
        detection_clock(c.detections.enabled, c.detections.rate_hz),
        gps_clock(c.gps.enabled, c.gps.rate_hz) {}

  static MotionInput atRest(MotionInput input);
  SimulatedEvent moveOn();
  /// When the next scan is complete.
  double scanEnd_s() const { return scan_clock.next_s() + laser.sweep_s(); }
  SimulatedEvent takeScan();
  LaserView viewAt(double time_s) const;
  SimulatedEvent detectLandmarks();
  std::optional<SimulatedEvent> fixPosition();
  std::optional<SimulatedEvent> nextOf();
  std::optional<double> measureHeight(const Pose2& T_map_base);

  Scene sceneAt(double time_s, const Eigen::Vector2d& place, double range_m) const;
  std::vector<TrueLandmark> landmarksNear(const Eigen::Vector2d& place, double range_m) const;
  std::vector<Disc> reflectorsNear(const Eigen::Vector2d& place, double range_m) const;

  SimulationConfig config;
  VehicleConfig vehicle_config;
  Pose2 T_enu_map;
  World world;  ///< in map
  RayCaster caster;
  SimulatedVehicle vehicle;
  SimulatedLaser laser;
  SimulatedDetector detector;
  SimulatedGps gps;
  RandomGenerator altimeter;
  Clock motion_clock, scan_clock, detection_clock, gps_clock;
  bool ended = false;
};

Scene Simulation::State::sceneAt(double time_s, const Eigen::Vector2d& place,
                                 double range_m) const {
  std::vector<Solid> moving;
  for (const Mover& mover : world.movers) {
    Solid solid = mover.at(time_s);
    if (boundsOf(solid.shape).exteriorDistance(place) < range_m) moving.push_back(std::move(solid));
  }
  return Scene(world.solids, caster, std::move(moving), &world.terrain);
}

std::vector<TrueLandmark> Simulation::State::landmarksNear(const Eigen::Vector2d& place,
                                                           double range_m) const {
  std::vector<TrueLandmark> nearby;
  for (const TrueLandmark& landmark : world.landmarks) {
    if ((landmark.position - place).squaredNorm() <= range_m * range_m) nearby.push_back(landmark);
  }
  return nearby;
}

std::vector<Disc> Simulation::State::reflectorsNear(const Eigen::Vector2d& place,
                                                    double range_m) const {
  std::vector<Disc> discs;
  for (const TrueLandmark& landmark : landmarksNear(place, range_m)) {
    if (landmark.type != LandmarkType::kReflector) continue;
    discs.push_back({landmark.position, landmark.diameter_m / 2.0});
  }
  return discs;
}

/// What the encoders say of a car whose wheels do not turn.
MotionInput Simulation::State::atRest(MotionInput input) {
  if (auto* readings = std::get_if<AckermannInput>(&input)) readings->speed_mps = 0.0;
  if (auto* twist = std::get_if<TwistInput>(&input)) {
    *twist = {twist->time_s, 0.0, 0.0, 0.0, std::nullopt};
  }
  return input;
}

SimulatedEvent Simulation::State::moveOn() {
  const double time_s = motion_clock.next_s();
  motion_clock.advance();
  const MotionInput input = vehicle.control(time_s, motion_clock.next_s() - time_s);
  const bool late = config.drive.duration_s > 0.0 &&
                    motion_clock.next_s() > kStartTime_s + config.drive.duration_s;
  ended = vehicle.isDone() || late;
  return {
      config.drive.isCarriedAt(time_s) ? atRest(input) : input, vehicle.T_map_base(time_s), {}, {}};
}

SimulatedEvent Simulation::State::takeScan() {
  const double time_s = scan_clock.next_s();
  scan_clock.advance();
  const Pose2 T_map_base = vehicle.T_map_base(time_s);
  SimulatedScan scan = laser.scan([this](double at_s) { return viewAt(at_s); }, time_s);
  return {ScanEvent{std::move(scan.scan), vehicle_config.laser.T_base_sensor()}, T_map_base,
          std::move(scan.beam_landmarks), measureHeight(T_map_base)};
}

LaserView Simulation::State::viewAt(double time_s) const {
  const BeamPlane plane(world.terrain, vehicle.T_map_base(time_s),
                        vehicle_config.laser.T_base_sensor(), config.laser.height_m);
  const Eigen::Vector2d place = plane.T_map_laser().position();
  const double range = config.laser.range_max_m;
  return {sceneAt(time_s, place, range), reflectorsNear(place, range), plane};
}

std::optional<double> Simulation::State::measureHeight(const Pose2& T_map_base) {
  if (world.terrain.isLevel()) return std::nullopt;
  return world.terrain.height(T_map_base.position()) +
         sampleNormal(altimeter, config.altimeter.deviation_m);
}

SimulatedEvent Simulation::State::detectLandmarks() {
  const double time_s = detection_clock.next_s();
  detection_clock.advance();
  const Pose2 T_map_base = vehicle.T_map_base(time_s);
  const Pose2 T_base_sensor = vehicle_config.laser.T_base_sensor();
  const Pose2 T_map_sensor = T_map_base * T_base_sensor;
  const double range = config.detections.range_max_m;
  const Scene scene = sceneAt(time_s, T_map_sensor.position(), range);
  ObservationSet set = detector.detect(scene, landmarksNear(T_map_sensor.position(), range),
                                       T_map_sensor, T_base_sensor, time_s);
  return {std::move(set), T_map_base, {}, {}};
}

std::optional<SimulatedEvent> Simulation::State::fixPosition() {
  const double time_s = gps_clock.next_s();
  gps_clock.advance();
  const Pose2 T_map_base = vehicle.T_map_base(time_s);
  const Eigen::Vector2d antenna(vehicle_config.gps_antenna.x_m, vehicle_config.gps_antenna.y_m);
  const auto fix = gps.fix(T_enu_map * (T_map_base * antenna), antenna, time_s);
  if (!fix) return std::nullopt;
  return SimulatedEvent{*fix, T_map_base, {}, {}};
}

Simulation::Simulation(const SimulationConfig& config, const VehicleConfig& vehicle,
                       std::uint64_t seed)
    : state_(std::make_unique<State>(config, vehicle, worldFor(config, vehicle, seed), seed)) {
  if (config.laser.range_min_m >= config.laser.range_max_m) {
    throw ConfigError({"simulation: laser.range_min_m must be less than laser.range_max_m."});
  }
  if (config.laser.rotating && config.laser.rate_hz < 1.0 / LaserScan::kLongestSweep_s) {
    throw ConfigError({"simulation: laser.rotating needs a laser.rate_hz of at least 1 Hz."});
  }
  MotionModel{vehicle};  // refuses geometry that cannot drive
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

/// Nothing where the next sensor has nothing to say.
std::optional<SimulatedEvent> Simulation::State::nextOf() {
  const double motion_s = motion_clock.next_s();
  const double scan_s = scanEnd_s();
  const double detection_s = detection_clock.next_s();
  const double first_s = std::min({motion_s, scan_s, detection_s, gps_clock.next_s()});
  if (first_s == motion_s) return moveOn();
  if (first_s == scan_s) return takeScan();
  if (first_s == detection_s) return detectLandmarks();
  return fixPosition();
}

std::optional<SimulatedEvent> Simulation::next() {
  State& state = *state_;
  while (!state.ended) {
    std::optional<SimulatedEvent> simulated = state.nextOf();
    if (!simulated) continue;
    const bool is_motion = std::holds_alternative<MotionInput>(simulated->event);
    if (is_motion || !state.config.drive.isCarriedAt(timeOf(simulated->event))) return simulated;
  }
  return std::nullopt;
}

double Simulation::progress() const { return state_->ended ? 1.0 : state_->vehicle.progress(); }

const std::vector<TrueLandmark>& Simulation::landmarks() const { return state_->world.landmarks; }

TrueOccupancy Simulation::occupancy(double resolution_m) const {
  return rasterised(state_->world, resolution_m);
}

const Terrain& Simulation::terrain() const { return state_->world.terrain; }

const Calibration& Simulation::calibration() const { return state_->vehicle.calibration(); }

const Pose2& Simulation::T_enu_map() const { return state_->T_enu_map; }

}  // namespace hymm::core
