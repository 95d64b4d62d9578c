// A scan of 12 observations through the relocaliser's particle filter, which associates nothing,
// and through two plain ones that do: one is told which landmark each observation is of, one takes
// the nearest from a table. All move their particles by the same code.

#include <cmath>
#include <string>
#include <vector>

#include "benchmark/benchmarks.h"
#include "relocaliser/density_map.h"
#include "relocaliser/particle_filter.h"

namespace hymm::benchmarks {
namespace {

using core::LocalLandmark;
using core::ObservedPoint;
using core::ParticleSet;
using Eigen::Vector2d;

constexpr int kSeen = 12;
constexpr int kLandmarks = 40;
constexpr double kField_m = 80.0;
constexpr double kDeviation_m = 0.2;
constexpr double kView_m2 = 1400.0;  // half a disc of 30 m
constexpr double kNearestCell_m = 0.25;

/// Landmarks around a vehicle at the origin, a scan of twelve of them, and particles.
struct Scene {
  explicit Scene(std::size_t count) : generator(1) {
    for (int i = 0; i < kLandmarks; ++i) {
      const double half = i < kSeen ? 20.0 : kField_m / 2.0;
      const Vector2d place(core::sampleUniform(generator, i < kSeen ? 0.0 : -half, half),
                           core::sampleUniform(generator, -half, half));
      landmarks.push_back({i, place, 0.01 * Eigen::Matrix2d::Identity()});
      if (i >= kSeen) continue;
      const Vector2d seen =
          place + Vector2d(core::sampleNormal(generator, 0.1), core::sampleNormal(generator, 0.1));
      points.push_back({seen.cast<float>(), kDeviation_m, seen.norm()});
    }
    for (std::size_t i = 0; i < count; ++i) {
      particles.add({core::sampleNormal(generator, 0.5), core::sampleNormal(generator, 0.5),
                     core::sampleNormal(generator, 0.05)});
    }
    step.mean << 0.6F, 0.0F, 0.01F;
    step.root.diagonal() << 0.02F, 0.01F, 0.003F;
    back = step;
    back.mean = -step.mean;
  }

  /// To and fro, so that the scan goes on to fit.
  const core::NoisyStep& nextStep() { return (++steps % 2) != 0 ? step : back; }

  core::RandomGenerator generator;
  std::vector<LocalLandmark> landmarks;
  std::vector<ObservedPoint> points;
  ParticleSet particles;
  core::NoisyStep step, back;
  int steps = 0;
};

void countItems(benchmark::State& state, std::size_t particles, std::size_t resampled) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(particles));
  state.counters["resampled"] =
      static_cast<double>(resampled) / static_cast<double>(state.iterations());
}

core::ParticleFilterConfig constantNumber(std::size_t count) {
  core::ParticleFilterConfig config;
  config.min_particles = config.max_particles = static_cast<int>(count);
  return config;
}

/// Everything that a scan takes: the map's density for it, motion, weights, resampling when due.
void withoutAssociation(benchmark::State& state, std::size_t count) {
  Scene scene(count);
  core::ParticleFilter filter(constantNumber(count));
  filter.begin(scene.particles);
  std::size_t resampled = 0;
  for (auto _ : state) {
    filter.move(scene.nextStep(), scene.generator);
    filter.weigh(core::DensityMap(scene.landmarks, scene.points, kView_m2, {}));
    if (filter.resampleIfDue(scene.generator)) ++resampled;
  }
  countItems(state, count, resampled);
}

/// The landmark of each observation, as it is known.
struct KnownIdentities {
  explicit KnownIdentities(const Scene&) {}
  std::size_t operator()(std::size_t observation, float, float) const { return observation; }
};

/// The nearest landmark, from a table.
class NearestLandmark {
 public:
  explicit NearestLandmark(const Scene& scene) : table_(kCells * kCells) {
    for (std::size_t v = 0; v < kCells; ++v) {
      for (std::size_t u = 0; u < kCells; ++u) table_[v * kCells + u] = nearest(scene, u, v);
    }
  }
  std::size_t operator()(std::size_t, float x, float y) const {
    return table_[cell(y) * kCells + cell(x)];
  }

 private:
  static constexpr std::size_t kCells = 400;  // of 0.25 m: 100 m

  static std::size_t cell(float value) {
    const float place = (value + 50.0F) * 4.0F;
    return static_cast<std::size_t>(std::min(std::max(place, 0.0F), 399.0F));
  }
  static std::uint16_t nearest(const Scene& scene, std::size_t u, std::size_t v) {
    const Vector2d place(kNearestCell_m * (static_cast<double>(u) + 0.5) - 50.0,
                         kNearestCell_m * (static_cast<double>(v) + 0.5) - 50.0);
    std::uint16_t best = 0;
    for (std::size_t i = 1; i < scene.landmarks.size(); ++i) {
      if ((scene.landmarks[i].position - place).norm() <
          (scene.landmarks[best].position - place).norm()) {
        best = static_cast<std::uint16_t>(i);
      }
    }
    return best;
  }

  std::vector<std::uint16_t> table_;
};

/// Sampling importance resampling as a textbook has it.
template <class Identify>
void withAssociation(benchmark::State& state, std::size_t count) {
  Scene scene(count);
  const Identify identify(scene);
  const float per_variance = -0.5F / static_cast<float>(kDeviation_m * kDeviation_m + 0.01);
  ParticleSet& particles = scene.particles;
  ParticleSet copy;
  std::size_t resampled = 0;
  for (auto _ : state) {
    core::moveParticles(scene.nextStep(), scene.generator(), particles);
    for (std::size_t i = 0; i < count; ++i) {
      const float c = std::cos(particles.yaw_rad[i]), s = std::sin(particles.yaw_rad[i]);
      float sum = 0.0F;
      for (std::size_t k = 0; k < scene.points.size(); ++k) {
        const Eigen::Vector2f& p = scene.points[k].p_base_point;
        const float x = particles.x_m[i] + c * p.x() - s * p.y();
        const float y = particles.y_m[i] + s * p.x() + c * p.y();
        const LocalLandmark& landmark = scene.landmarks[identify(k, x, y)];
        const float dx = x - static_cast<float>(landmark.position.x());
        const float dy = y - static_cast<float>(landmark.position.y());
        sum += dx * dx + dy * dy;
      }
      particles.log_weight[i] += per_variance * sum;
    }
    const core::WeightSums sums = core::normaliseWeights(particles);
    if (sums.effectiveNumber() >= 0.5 * static_cast<double>(count)) continue;
    ++resampled;
    const auto drawn = core::drawLowVariance(particles.weight, count,
                                             core::sampleUniform(scene.generator, 0.0, 1.0));
    copy.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      copy.x_m[i] = particles.x_m[drawn[i]];
      copy.y_m[i] = particles.y_m[drawn[i]];
      copy.yaw_rad[i] = particles.yaw_rad[drawn[i]];
      copy.log_weight[i] = 0.0F;
    }
    std::swap(particles, copy);
  }
  countItems(state, count, resampled);
}

}  // namespace

void registerParticleBenchmarks(Registration& registration) {
  const auto in_milliseconds = [](benchmark::internal::Benchmark* benchmark) {
    benchmark->Unit(benchmark::kMillisecond);
  };
  for (const std::size_t count : {10000U, 100000U, 1000000U}) {
    const std::string n = "/" + std::to_string(count);
    registration.add(
        "BM_ParticleUpdate" + n,
        [count](benchmark::State& state) { withoutAssociation(state, count); }, in_milliseconds);
    registration.add(
        "BM_ParticleUpdateKnownIdentities" + n,
        [count](benchmark::State& state) { withAssociation<KnownIdentities>(state, count); },
        in_milliseconds);
    registration.add(
        "BM_ParticleUpdateNearest" + n,
        [count](benchmark::State& state) { withAssociation<NearestLandmark>(state, count); },
        in_milliseconds);
  }
}

}  // namespace hymm::benchmarks
