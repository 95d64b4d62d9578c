#include "relocaliser/particle_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/random.h"
#include "relocaliser/normal_table.h"

// Each kernel is compiled for several widths of vectors, and the loader takes the widest that the
// machine has: so the build that everybody gets is as fast as one made for this machine. The
// resolvers that this takes run before a sanitizer is ready. Levels, not models of processors: for
// some of these the compiler takes gather instructions, which mitigations of Downfall have made ten
// times slower than single loads.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HYMM_FOR_EACH_VECTOR_WIDTH \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HYMM_FOR_EACH_VECTOR_WIDTH
#endif

namespace hymm::core {
namespace {

// Particles that are worked on together: their scratch stays in the first cache.
constexpr std::size_t kTile = 512;

// Below this log weight a particle counts as impossible; its weight is zero in float.
constexpr float kLeastLogWeight = -1e30F;

/// Nearest whole number for |value| < 2^22, in a way that every vector unit has.
inline float nearestWhole(float value) {
  constexpr float kShift = 12582912.0F;  // 1.5 * 2^23
  return (value + kShift) - kShift;
}

/// Sine and cosine to 2e-7 for angles of a few turns: reduced to an eighth of a turn either side,
/// Taylor there, and exchanged by quadrant.
inline void sineCosine(float angle, float& sine, float& cosine) {
  constexpr float kQuadrantsPerRad = 0.636619772F;
  constexpr float kQuadrant = 1.57079637F, kQuadrantRest = -4.37113883e-8F;
  const float quadrant = nearestWhole(angle * kQuadrantsPerRad);
  const float r = (angle - quadrant * kQuadrant) - quadrant * kQuadrantRest;
  const float r2 = r * r;
  const float s =
      r * (1.0F + r2 * (-1.66666667e-1F +
                        r2 * (8.33333333e-3F + r2 * (-1.98412698e-4F + r2 * 2.75573192e-6F))));
  const float c =
      1.0F + r2 * (-0.5F + r2 * (4.16666667e-2F + r2 * (-1.38888889e-3F + r2 * 2.48015873e-5F)));
  const auto q = static_cast<std::int32_t>(quadrant);
  const bool exchanged = (q & 1) != 0;
  const float a = exchanged ? c : s, b = exchanged ? s : c;
  sine = (q & 2) != 0 ? -a : a;
  cosine = ((q + 1) & 2) != 0 ? -b : b;
}

/// exp for arguments from -87 to 0, to 1e-6 of the value; zero below.
inline float exponential(float value) {
  constexpr float kBitsPerUnit = 1.44269504F;
  constexpr float kLn2High = 0.693359375F, kLn2Low = -2.12194440e-4F;
  const float v = value < -87.0F ? -87.0F : value;
  const float n = nearestWhole(v * kBitsPerUnit);
  const float r = (v - n * kLn2High) - n * kLn2Low;
  const float p =
      1.0F +
      r * (1.0F +
           r * (0.5F + r * (1.66666667e-1F +
                            r * (4.16666667e-2F + r * (8.33333333e-3F + r * 1.38888889e-3F)))));
  const std::int32_t bits = (static_cast<std::int32_t>(n) + 127) << 23;
  float power = 0.0F;
  std::memcpy(&power, &bits, sizeof power);
  return value < -87.0F ? 0.0F : p * power;
}

/// A well mixed function of 32 bits (two rounds of multiplication and shift).
inline std::uint32_t mixed(std::uint32_t value) {
  value ^= value >> 16;
  value *= 0x7feb352dU;
  value ^= value >> 15;
  value *= 0x846ca68bU;
  value ^= value >> 16;
  return value;
}

struct Range {
  std::size_t begin;
  std::size_t end;
};

/// Where the particles of a tile stand and look, in cells.
struct TilePoses {
  std::array<float, kTile> u, v;          ///< place
  std::array<float, kTile> cosine, sine;  ///< of the heading, times cells per metre
};

HYMM_FOR_EACH_VECTOR_WIDTH
void takePoses(Range range, const LookupGrid& grid, const float* __restrict x,
               const float* __restrict y, const float* __restrict yaw, TilePoses& tile) {
  const float scale = grid.cells_per_m;
  const std::size_t n = range.end - range.begin;
  for (std::size_t i = 0; i < n; ++i) {
    float sine = 0.0F, cosine = 0.0F;
    sineCosine(yaw[range.begin + i], sine, cosine);
    tile.cosine[i] = cosine * scale;
    tile.sine[i] = sine * scale;
    tile.u[i] = (x[range.begin + i] - grid.origin_x_m) * scale;
    tile.v[i] = (y[range.begin + i] - grid.origin_y_m) * scale;
  }
}

HYMM_FOR_EACH_VECTOR_WIDTH
void findCells(const LookupGrid& grid, const LookupPoint& point, const TilePoses& tile,
               std::size_t count, std::int32_t* __restrict cells) {
  const auto greatest_u = static_cast<float>(grid.width - 1);
  const auto greatest_v = static_cast<float>(grid.height - 1);
  const std::int32_t width = grid.width;
  const float px = point.x_m, py = point.y_m;
  for (std::size_t i = 0; i < count; ++i) {
    float u = tile.u[i] + tile.cosine[i] * px - tile.sine[i] * py;
    float v = tile.v[i] + tile.sine[i] * px + tile.cosine[i] * py;
    u = u > 0.0F ? u : 0.0F;  // NaN too
    v = v > 0.0F ? v : 0.0F;
    u = u < greatest_u ? u : greatest_u;
    v = v < greatest_v ? v : greatest_v;
    cells[i] = static_cast<std::int32_t>(v) * width + static_cast<std::int32_t>(u);
  }
}

/// Looks points up for a tile of particles, a few points at a time: cells are computed a vector at
/// a time, and then read one by one, particle by particle, which no vector instruction does faster.
void addLookupsIn(Range range, const LookupGrid& grid, const LookupPoint* points, std::size_t count,
                  ParticleSet& particles) {
  constexpr std::size_t kTogether = 8;
  TilePoses tile;
  std::array<std::array<std::int32_t, kTile>, kTogether> cells;
  std::array<const float*, kTogether> tables;
  takePoses(range, grid, particles.x_m.data(), particles.y_m.data(), particles.yaw_rad.data(),
            tile);
  const std::size_t n = range.end - range.begin;
  for (std::size_t first = 0; first < count; first += kTogether) {
    const std::size_t together = std::min(kTogether, count - first);
    for (std::size_t k = 0; k < together; ++k) {
      findCells(grid, points[first + k], tile, n, cells[k].data());
      tables[k] = points[first + k].table;
    }
    for (std::size_t i = 0; i < n; ++i) {
      float sum = 0.0F;
      for (std::size_t k = 0; k < together; ++k) sum += tables[k][cells[k][i]];
      particles.log_weight[range.begin + i] += sum;
    }
  }
}

HYMM_FOR_EACH_VECTOR_WIDTH
void moveParticlesIn(Range range, const NoisyStep& step, std::uint32_t key,
                     std::uint32_t second_key, const float* __restrict normals, float* __restrict x,
                     float* __restrict y, float* __restrict yaw) {
  const float mean_x = step.mean[0], mean_y = step.mean[1], mean_turn = step.mean[2];
  const float l00 = step.root(0, 0), l10 = step.root(1, 0), l11 = step.root(1, 1),
              l20 = step.root(2, 0), l21 = step.root(2, 1), l22 = step.root(2, 2);
  constexpr std::uint32_t kMask = NormalTable::kSize - 1;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const std::uint32_t bits = mixed(static_cast<std::uint32_t>(i) * 0x9e3779b9U + key);
    const std::uint32_t more = mixed(bits ^ second_key);
    const float n0 = normals[bits & kMask];
    const float n1 = normals[(bits >> 16) & kMask];
    const float n2 = normals[more & kMask];
    const float forward = mean_x + l00 * n0;
    const float left = mean_y + l10 * n0 + l11 * n1;
    float sine = 0.0F, cosine = 0.0F;
    sineCosine(yaw[i], sine, cosine);
    x[i] += cosine * forward - sine * left;
    y[i] += sine * forward + cosine * left;
    yaw[i] += mean_turn + l20 * n0 + l21 * n1 + l22 * n2;
  }
}

HYMM_FOR_EACH_VECTOR_WIDTH
float greatestOf(const float* __restrict values, std::size_t count) {
  constexpr std::size_t kLanes = 64;
  std::array<float, kLanes> greatest;
  greatest.fill(kLeastLogWeight);
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      greatest[k] = values[i + k] > greatest[k] ? values[i + k] : greatest[k];
    }
  }
  for (; i < count; ++i) greatest[0] = values[i] > greatest[0] ? values[i] : greatest[0];
  return *std::max_element(greatest.begin(), greatest.end());
}

HYMM_FOR_EACH_VECTOR_WIDTH
WeightSums shiftAndSumIn(Range range, float shift, float* __restrict log_weight,
                         float* __restrict weights) {
  constexpr std::size_t kLanes = 64;
  std::array<float, kLanes> sums{}, squares{};
  const auto take = [&](std::size_t i, std::size_t lane) {
    const float shifted = log_weight[i] - shift;
    const float kept = shifted > kLeastLogWeight ? shifted : kLeastLogWeight;  // NaN too
    log_weight[i] = kept;
    const float weight = exponential(kept);
    weights[i] = weight;
    sums[lane] += weight;
    squares[lane] += weight * weight;
  };
  std::size_t i = range.begin;
  for (; i + kLanes <= range.end; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) take(i + k, k);
  }
  for (; i < range.end; ++i) take(i, 0);
  WeightSums result;
  for (std::size_t k = 0; k < kLanes; ++k) {
    result.sum += static_cast<double>(sums[k]);
    result.sum_squares += static_cast<double>(squares[k]);
  }
  return result;
}

template <class Function>
void forEachTile(std::size_t count, Function function) {
  for (std::size_t begin = 0; begin < count; begin += kTile) {
    function(Range{begin, std::min(count, begin + kTile)});
  }
}

}  // namespace

void addLookups(const LookupGrid& grid, const LookupPoint* points, std::size_t count,
                ParticleSet& particles) {
  forEachTile(particles.size(),
              [&](Range range) { addLookupsIn(range, grid, points, count, particles); });
}

void moveParticles(const NoisyStep& step, std::uint64_t seed, ParticleSet& particles) {
  const NormalTable& normals = NormalTable::instance();
  const auto key = static_cast<std::uint32_t>(seed);
  const auto second_key = static_cast<std::uint32_t>(seed >> 32);
  moveParticlesIn({0, particles.size()}, step, key, second_key, normals.data(),
                  particles.x_m.data(), particles.y_m.data(), particles.yaw_rad.data());
}

WeightSums normaliseWeights(ParticleSet& particles) {
  const float greatest = greatestOf(particles.log_weight.data(), particles.size());
  WeightSums total;
  forEachTile(particles.size(), [&](Range range) {
    const WeightSums sums =
        shiftAndSumIn(range, greatest, particles.log_weight.data(), particles.weight.data());
    total.sum += sums.sum;
    total.sum_squares += sums.sum_squares;
  });
  return total;
}

}  // namespace hymm::core
