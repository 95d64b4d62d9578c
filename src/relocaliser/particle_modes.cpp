#include "relocaliser/particle_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace hymm::core {
namespace {

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

/// Gives all bins that hang together with `start`, corners included, its mode.
void spreadMode(FilledBins& bins, const Binning& binning, std::int32_t start, int mode) {
  std::vector<std::int32_t> waiting{start};
  bins.contents[static_cast<std::size_t>(start)].mode = mode;
  while (!waiting.empty()) {
    const Bin bin = bins.contents[static_cast<std::size_t>(waiting.back())].bin;
    waiting.pop_back();
    for (int step = 0; step < 27; ++step) {
      const Bin neighbour{bin[0] + step % 3 - 1, bin[1] + step / 3 % 3 - 1, bin[2] + step / 9 - 1};
      const auto found = bins.index.find(binning.key(neighbour));
      if (found == bins.index.end()) continue;
      BinContent& content = bins.contents[static_cast<std::size_t>(found->second)];
      if (content.mode >= 0) continue;
      content.mode = mode;
      waiting.push_back(found->second);
    }
  }
}

/// First and second moments of a mode about its first particle.
struct Moments {
  double weight = 0.0;
  Pose2 about;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(const Pose2& pose, double w) {
    if (weight == 0.0) about = pose;
    Eigen::Vector3d d = pose.vector() - about.vector();
    d[2] = wrapAngle(d[2]);
    weight += w;
    first += w * d;
    second += w * d * d.transpose();
  }
  ParticleMode mode(double total) const {
    const Eigen::Vector3d mean = first / weight;
    return {weight / total, Pose2::fromVector(about.vector() + mean),
            second / weight - mean * mean.transpose()};
  }
};

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
    moments[static_cast<std::size_t>(mode)].add(particles.pose(i), weight);
    total += weight;
  }
  std::vector<ParticleMode> modes;
  for (const Moments& moment : moments) {
    if (moment.weight >= least_share * total) modes.push_back(moment.mode(total));
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
