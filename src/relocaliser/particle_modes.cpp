#include "relocaliser/particle_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace hymm::core {
namespace {

constexpr double kDimensions = 3.0;

// Effective particles by which a covariance is told, at least: where n^(2/3) (n + 1) / (n - 5) is
// least.
constexpr double kFewestEffective = 14.0;

// A particle with less weight than this, against the heaviest, belongs to no mode.
constexpr float kLeastLogWeight = -20.0F;

using Bin = std::array<std::int32_t, 3>;

class Binning {
 public:
  explicit Binning(const BinSize& size)
      : per_m_(static_cast<float>(1.0 / size.length_m)),
        turns_(std::max(1, static_cast<std::int32_t>(std::lround(2.0 * kPi / size.turn_rad)))) {}

  Bin binOf(const ParticleSet& particles, std::size_t i) const {
    const float turn = particles.yaw_rad[i] * kPerTurn;
    return {
        static_cast<std::int32_t>(std::floor(particles.x_m[i] * per_m_)),
        static_cast<std::int32_t>(std::floor(particles.y_m[i] * per_m_)),
        static_cast<std::int32_t>((turn - std::floor(turn)) * static_cast<float>(turns_)) % turns_};
  }
  /// Unique for places within 2^20 bins of the origin.
  std::uint64_t key(const Bin& bin) const {
    const auto part = [](std::int32_t value) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value + (1 << 20)) & 0x1fffffU);
    };
    return part(bin[0]) << 42 | part(bin[1]) << 21 | part((bin[2] + turns_) % turns_);
  }

 private:
  static constexpr float kPerTurn = static_cast<float>(0.5 / kPi);

  float per_m_;
  std::int32_t turns_;  ///< bins of a whole turn
};

/// Keys in one array: a filter counts its bins whenever it resamples.
class KeySet {
 public:
  explicit KeySet(std::size_t most) {
    std::size_t capacity = 16;
    while (capacity < 2 * most) capacity *= 2;
    slots_.assign(capacity, kEmpty);
  }
  void insert(std::uint64_t key) {
    std::size_t slot = (key * 0x9e3779b97f4a7c15U >> 20) & (slots_.size() - 1);
    while (slots_[slot] != kEmpty && slots_[slot] != key) slot = (slot + 1) & (slots_.size() - 1);
    if (slots_[slot] == key) return;
    slots_[slot] = key;
    ++size_;
  }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  std::vector<std::uint64_t> slots_;
  std::size_t size_ = 0;
};

struct BinContent {
  Bin bin;
  double weight = 0.0;
  int mode = -1;
};

/// Bins that hold weight, and the bin of each particle (-1: none).
struct FilledBins {
  std::vector<BinContent> contents;
  std::vector<std::int32_t> of_particle;
  std::unordered_map<std::uint64_t, std::int32_t> index;
};

FilledBins fillBins(const ParticleSet& particles, const Binning& binning) {
  FilledBins bins;
  bins.of_particle.assign(particles.size(), -1);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!(particles.log_weight[i] > kLeastLogWeight)) continue;
    const Bin bin = binning.binOf(particles, i);
    const auto next = static_cast<std::int32_t>(bins.contents.size());
    const auto [entry, is_new] = bins.index.try_emplace(binning.key(bin), next);
    if (is_new) bins.contents.push_back({bin, 0.0, -1});
    bins.of_particle[i] = entry->second;
    bins.contents[static_cast<std::size_t>(entry->second)].weight +=
        static_cast<double>(particles.weight[i]);
  }
  return bins;
}

/// The bin itself, and all that it touches, corners included.
template <class Function>
void forEachNeighbour(const Bin& bin, Function function) {
  for (int step = 0; step < 27; ++step) {
    function(Bin{bin[0] + step % 3 - 1, bin[1] + step / 3 % 3 - 1, bin[2] + step / 9 - 1});
  }
}

/// Gives all bins that hang together with `start`, corners included, its mode.
void spreadMode(FilledBins& bins, const Binning& binning, std::int32_t start, int mode) {
  std::vector<std::int32_t> waiting{start};
  bins.contents[static_cast<std::size_t>(start)].mode = mode;
  while (!waiting.empty()) {
    const Bin bin = bins.contents[static_cast<std::size_t>(waiting.back())].bin;
    waiting.pop_back();
    forEachNeighbour(bin, [&](const Bin& neighbour) {
      const auto found = bins.index.find(binning.key(neighbour));
      if (found == bins.index.end()) return;
      BinContent& content = bins.contents[static_cast<std::size_t>(found->second)];
      if (content.mode >= 0) return;
      content.mode = mode;
      waiting.push_back(found->second);
    });
  }
}

/// By how much n effective samples of a Gaussian have to be spread to tell of the next one: the
/// covariance of Student's distribution that is left when mean and covariance are unknown.
double factorOf(double effective_number) {
  return (effective_number + 1.0) / (effective_number - kDimensions - 2.0);
}

/// First and second moments of a mode about its first particle.
struct Moments {
  double weight = 0.0;
  double squares = 0.0;  ///< of the weights
  double greatest = 0.0;
  std::size_t heaviest = 0;  ///< index of the particle of the greatest weight
  Pose2 about;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(std::size_t particle, const Pose2& pose, double w) {
    if (w > greatest) {
      greatest = w;
      heaviest = particle;
    }
    if (weight == 0.0) about = pose;
    Eigen::Vector3d d = pose.vector() - about.vector();
    d[2] = wrapAngle(d[2]);
    weight += w;
    squares += w * w;
    first += w * d;
    second += w * d * d.transpose();
  }
  ParticleMode asMode(double total) const {
    const Eigen::Vector3d mean = first / weight;
    ParticleMode mode;
    mode.share = weight / total;
    mode.mean = Pose2::fromVector(about.vector() + mean);
    mode.spread = second / weight - mean * mean.transpose();
    mode.effective_number = weight * weight / squares;
    return mode;
  }
};

/// Particles in the bin of one of them and next to it, whatever their weight: where they stand from
/// it, and their log weights against the greatest.
struct Surroundings {
  std::vector<Eigen::Vector3d> offsets;
  std::vector<double> log_weights;
};

/// All particles in the order of their bins, made when a mode first asks: few scans need it.
class ParticlesByBin {
 public:
  ParticlesByBin(const ParticleSet& particles, const Binning& binning)
      : particles_(particles), binning_(binning) {}

  Surroundings around(std::size_t particle) {
    if (ordered_.empty()) order();
    Surroundings result;
    forEachNeighbour(binning_.binOf(particles_, particle), [&](const Bin& neighbour) {
      add(binning_.key(neighbour), particles_.pose(particle), result);
    });
    const double greatest = *std::max_element(result.log_weights.begin(), result.log_weights.end());
    for (double& log_weight : result.log_weights) log_weight -= greatest;
    return result;
  }

 private:
  void order() {
    ordered_.reserve(particles_.size());
    for (std::size_t i = 0; i < particles_.size(); ++i) {
      ordered_.emplace_back(binning_.key(binning_.binOf(particles_, i)), i);
    }
    std::sort(ordered_.begin(), ordered_.end());
  }
  void add(std::uint64_t key, const Pose2& middle, Surroundings& result) const {
    auto entry = std::lower_bound(ordered_.begin(), ordered_.end(), Entry{key, 0});
    for (; entry != ordered_.end() && entry->first == key; ++entry) {
      Eigen::Vector3d offset = particles_.pose(entry->second).vector() - middle.vector();
      offset[2] = wrapAngle(offset[2]);
      result.offsets.push_back(offset);
      result.log_weights.push_back(static_cast<double>(particles_.log_weight[entry->second]));
    }
  }

  using Entry = std::pair<std::uint64_t, std::size_t>;

  const ParticleSet& particles_;
  const Binning& binning_;
  std::vector<Entry> ordered_;
};

double effectiveNumber(const std::vector<double>& log_weights, double scale) {
  double sum = 0.0, squares = 0.0;
  for (const double log_weight : log_weights) {
    const double weight = std::exp(scale * log_weight);
    sum += weight;
    squares += weight * weight;
  }
  return sum * sum / squares;
}

/// The greatest scale of the log weights, of at most 1, with which enough particles are effective.
double enoughScale(const std::vector<double>& log_weights) {
  double exponent = 0.0;  // of 2: weights may be apart by any number of magnitudes
  while (effectiveNumber(log_weights, std::exp2(exponent)) < kFewestEffective) --exponent;
  double least = exponent, greatest = std::min(0.0, exponent + 1.0);
  for (int i = 0; i < 10; ++i) {
    const double middle = 0.5 * (least + greatest);
    const bool is_enough = effectiveNumber(log_weights, std::exp2(middle)) >= kFewestEffective;
    (is_enough ? least : greatest) = middle;
  }
  return std::exp2(least);
}

/// How far the particles about the heaviest one leave open where it should stand. The moment is
/// about it: if all that weigh less stand to one side, the place is not known to that side.
Eigen::Matrix3d kernelCovariance(const Surroundings& near, const BinSize& bin) {
  if (static_cast<double>(near.offsets.size()) <= kFewestEffective) {
    // Anywhere in a bin or those next to it.
    const Eigen::Vector3d width = 3.0 * Eigen::Vector3d(bin.length_m, bin.length_m, bin.turn_rad);
    return (width.cwiseAbs2() / 12.0).asDiagonal();
  }
  const double scale = enoughScale(near.log_weights);
  double sum = 0.0;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < near.offsets.size(); ++i) {
    const double weight = std::exp(scale * near.log_weights[i]);
    sum += weight;
    second += weight * near.offsets[i] * near.offsets[i].transpose();
  }
  return factorOf(effectiveNumber(near.log_weights, scale)) * second / sum;
}

}  // namespace

std::vector<ParticleMode> computeModes(const ParticleSet& particles, const BinSize& bin,
                                       double least_share) {
  const Binning binning(bin);
  FilledBins bins = fillBins(particles, binning);
  int count = 0;
  for (std::size_t i = 0; i < bins.contents.size(); ++i) {
    if (bins.contents[i].mode < 0) spreadMode(bins, binning, static_cast<std::int32_t>(i), count++);
  }
  std::vector<Moments> moments(static_cast<std::size_t>(count));
  double total = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (bins.of_particle[i] < 0) continue;
    const double weight = static_cast<double>(particles.weight[i]);
    const int mode = bins.contents[static_cast<std::size_t>(bins.of_particle[i])].mode;
    moments[static_cast<std::size_t>(mode)].add(i, particles.pose(i), weight);
    total += weight;
  }
  ParticlesByBin by_bin(particles, binning);
  std::vector<ParticleMode> modes;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (moments[i].weight < least_share * total) continue;
    modes.push_back(moments[i].asMode(total));
    ParticleMode& mode = modes.back();
    if (mode.effective_number >= kFewestEffective) {
      mode.covariance = factorOf(mode.effective_number) * mode.spread;
    } else {
      mode.covariance = mode.spread + kernelCovariance(by_bin.around(moments[i].heaviest), bin);
    }
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const auto& a, const auto& b) { return a.share > b.share; });
  return modes;
}

std::size_t countBins(const ParticleSet& particles, const std::vector<std::size_t>& indices,
                      const BinSize& bin) {
  const Binning binning(bin);
  KeySet keys(indices.size());
  for (const std::size_t i : indices) keys.insert(binning.key(binning.binOf(particles, i)));
  return keys.size();
}

}  // namespace hymm::core
