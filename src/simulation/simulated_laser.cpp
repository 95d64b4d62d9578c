#include "simulation/simulated_laser.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hymm::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSameMoment_s = 2e-4;     // a vehicle of 5 m/s moves on by a millimetre
constexpr double kDarkReflectivity = 0.1;  // of the target that dark_range_m speaks of

// Intensities, in units of the SICK LMS recordings: a near retro-reflector fills the scale, and
// what a reflector gives back has halved at 30 m. Other surfaces stay under the first step.
constexpr double kFullIntensity = 32768.0;
constexpr double kHalfIntensityRange_m = 30.0;
constexpr double kDiffuseIntensity = 4096.0;

/// Short grass.
const Solid kGround{Disc{}, {0.3, false, 0.03}, -1};

/// Number of beams in a row that count as cast at the same moment.
std::size_t beamsAtOnce(const LaserScan& scan) {
  const auto beams = static_cast<double>(scan.ranges_m.size());
  if (scan.time_increment_s <= 0.0) return scan.ranges_m.size();
  const double at_once = std::floor(kSameMoment_s / scan.time_increment_s);
  return static_cast<std::size_t>(std::clamp(at_once, 1.0, beams));
}

}  // namespace

Scene::Scene(const std::vector<Solid>& standing, const RayCaster& standing_caster,
             std::vector<Solid> moving, const Terrain* terrain)
    : standing_(standing),
      standing_caster_(standing_caster),
      moving_(std::move(moving)),
      moving_caster_(moving_),
      terrain_(terrain) {}

std::optional<Scene::Hit> Scene::cast(const Beam& beam, double range_max_m) const {
  const double plan_range_max_m = range_max_m / beam.stretch;
  std::optional<Hit> hit;  // its range in plan, until the end
  if (const auto met = standing_caster_.cast(beam.origin, beam.direction, plan_range_max_m)) {
    hit = Hit{met->range_m, met->incidence_cosine, &standing_[met->solid]};
  }
  const auto limit = [&] { return hit ? hit->range_m : plan_range_max_m; };
  if (const auto met = moving_caster_.cast(beam.origin, beam.direction, limit())) {
    hit = Hit{met->range_m, met->incidence_cosine, &moving_[met->solid]};
  }
  const auto ground = terrain_ != nullptr ? terrain_->meet(beam, limit()) : std::nullopt;
  if (ground) hit = Hit{ground->plan_range_m, ground->incidence_cosine, &kGround};
  if (hit) hit->range_m *= beam.stretch;
  return hit;
}

SimulatedLaser::SimulatedLaser(const SimulatedLaserConfig& config, RandomGenerator generator)
    : config_(config), generator_(generator), sweep_s_(emptyScan(0.0).sweep_s()) {}

/// All that is known before the first beam; ranges are NaN.
LaserScan SimulatedLaser::emptyScan(double time_s) const {
  const double view = std::min(config_.field_of_view_rad, 2.0 * kPi);
  const bool whole_turn = view > 2.0 * kPi - 1e-3;  // then the last beam is not the first again
  const auto beams = static_cast<std::size_t>(config_.beams);
  LaserScan scan;
  scan.time_s = time_s;
  scan.angle_min_rad = -view / 2.0;
  scan.angle_increment_rad = view / (whole_turn ? config_.beams : config_.beams - 1);
  if (config_.rotating) {
    scan.time_increment_s = scan.angle_increment_rad / (2.0 * kPi * config_.rate_hz);
  }
  scan.range_min_m = config_.range_min_m;
  scan.range_max_m = config_.range_max_m;
  scan.ranges_m.assign(beams, std::numeric_limits<float>::quiet_NaN());
  scan.intensities.assign(beams, 0.0F);
  return scan;
}

SimulatedScan SimulatedLaser::scan(const View& view, double time_s) {
  SimulatedScan result{emptyScan(time_s), {}};
  const std::size_t beams = result.scan.ranges_m.size();
  const std::size_t size = beamsAtOnce(result.scan);
  result.beam_landmarks.reserve(beams);
  for (std::size_t first = 0; first < beams; first += size) {
    const Group group{first, std::min(first + size, beams)};
    const double middle = 0.5 * static_cast<double>(group.first + group.end - 1);
    cast(view(time_s + middle * result.scan.time_increment_s), group, result);
  }
  return result;
}

void SimulatedLaser::cast(const LaserView& view, const Group& group, SimulatedScan& result) {
  LaserScan& scan = result.scan;
  std::vector<Hit> hits(group.end - group.first);
  for (std::size_t i = group.first; i < group.end; ++i) {
    hits[i - group.first] = view.scene.cast(view.plane.beam(scan.bearing(i)), config_.range_max_m);
  }
  widenReflectors(view, scan, group, hits);

  for (std::size_t i = group.first; i < group.end; ++i) {
    Hit& hit = hits[i - group.first];
    result.beam_landmarks.push_back(hit ? hit->solid->landmark : -1);
    if (hit && !isReturned(*hit)) hit.reset();
    double range = kInfinity;
    if (hit) {
      range = mixedRange(view.scene, view.plane, scan.bearing(i), hit->range_m);
      range = measuredRange(range, hit->solid->material.roughness_m);
    }
    if (sampleUniform(generator_, 0.0, 1.0) < config_.spurious_return_probability) {
      range = sampleUniform(generator_, config_.range_min_m, std::min(range, config_.range_max_m));
      hit.reset();
    }
    scan.ranges_m[i] = reported(range);
    scan.intensities[i] = intensity(hit);
  }
}

/// A retro-reflector outshines whatever else lies within a beam's width.
void SimulatedLaser::widenReflectors(const LaserView& view, const LaserScan& scan,
                                     const Group& group, std::vector<Hit>& hits) const {
  const auto first_beam = static_cast<double>(group.first);
  const auto last_beam = static_cast<double>(group.end - 1);
  for (const Disc& reflector : view.reflectors) {
    const Eigen::Vector2d p = inverse(view.plane.T_map_laser()) * reflector.centre;
    const double distance = p.norm();
    if (distance <= reflector.radius_m || distance > config_.range_max_m) continue;
    const double bearing = std::atan2(p.y(), p.x());
    const double half_angle =
        std::asin(reflector.radius_m / distance) + config_.beam_width_rad / 2.0;
    const double first =
        std::max(first_beam,
                 std::ceil((bearing - half_angle - scan.angle_min_rad) / scan.angle_increment_rad));
    const double last =
        std::min(last_beam, (bearing + half_angle - scan.angle_min_rad) / scan.angle_increment_rad);
    if (first > last) continue;
    const auto seen = view.scene.cast(view.plane.beam(bearing), distance);
    if (!seen || !seen->solid->material.retro_reflective) continue;
    for (double i = first; i <= last; i += 1.0) {
      Hit& hit = hits[static_cast<std::size_t>(i) - group.first];
      const bool in_front = !hit || hit->range_m > seen->range_m;
      if (in_front && (!hit || hit->solid != seen->solid)) hit = seen;
    }
  }
}

/// Enough light comes back from bright, near and upright surfaces; it fades with the square of the
/// range, and the receiver's threshold is soft.
bool SimulatedLaser::isReturned(const Scene::Hit& hit) {
  if (sampleUniform(generator_, 0.0, 1.0) < config_.missed_return_probability) return false;
  const Material& material = hit.solid->material;
  if (config_.dark_range_m <= 0.0 || material.retro_reflective) return true;
  const double fading = config_.dark_range_m / hit.range_m;
  const double light =
      material.reflectivity / kDarkReflectivity * hit.incidence_cosine * fading * fading;
  const double steep = std::pow(light, 4.0);
  return sampleUniform(generator_, 0.0, 1.0) * (1.0 + steep) < steep;
}

/// Where the two sides of a beam meet different surfaces, it may report a range between them.
double SimulatedLaser::mixedRange(const Scene& scene, const BeamPlane& plane, double bearing_rad,
                                  double range_m) {
  constexpr double kEdge_m = 0.3;
  if (config_.mixed_pixel_probability <= 0.0) return range_m;
  double nearest = range_m, farthest = range_m;
  for (const double side : {-0.5, 0.5}) {
    const Beam beam = plane.beam(bearing_rad + side * config_.beam_width_rad);
    const auto hit = scene.cast(beam, config_.range_max_m);
    if (!hit) continue;
    nearest = std::min(nearest, hit->range_m);
    farthest = std::max(farthest, hit->range_m);
  }
  if (farthest < nearest + kEdge_m) return range_m;
  if (sampleUniform(generator_, 0.0, 1.0) >= config_.mixed_pixel_probability) return range_m;
  return sampleUniform(generator_, nearest, farthest);
}

double SimulatedLaser::measuredRange(double range_m, double roughness_m) {
  const double relative = config_.range_deviation_relative * range_m;
  const double deviation = std::sqrt(config_.range_deviation_m * config_.range_deviation_m +
                                     relative * relative + roughness_m * roughness_m);
  const double measured = range_m + config_.range_offset_m + sampleNormal(generator_, deviation);
  const double step = config_.range_resolution_m;
  return step > 0.0 ? step * std::round(measured / step) : measured;
}

float SimulatedLaser::intensity(const Hit& hit) {
  double value = sampleNormal(generator_, config_.intensity_deviation);
  if (hit && hit->solid->material.retro_reflective) {
    const double faded = hit->range_m / kHalfIntensityRange_m;
    value += kFullIntensity / (1.0 + faded * faded);
  } else if (hit) {
    value += kDiffuseIntensity * hit->solid->material.reflectivity * hit->incidence_cosine;
  }
  value = std::clamp(value, 0.0, kFullIntensity);
  const double step = config_.intensity_step;
  return static_cast<float>(step > 0.0 ? step * std::floor(value / step) : value);
}

/// REP-117.
float SimulatedLaser::reported(double range_m) const {
  if (range_m < config_.range_min_m) return -std::numeric_limits<float>::infinity();
  if (range_m > config_.range_max_m) return std::numeric_limits<float>::infinity();
  return static_cast<float>(range_m);
}

}  // namespace hymm::core
