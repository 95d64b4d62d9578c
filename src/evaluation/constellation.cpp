#include "evaluation/constellation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <unordered_map>

#include "evaluation/rigid_alignment.h"

namespace hymm::core {
namespace {

using Positions = std::vector<Eigen::Vector2d>;

constexpr std::size_t kLeastFitting = 5;
constexpr std::size_t kMostEstimatePairs = 60;
constexpr std::size_t kMostTruePairs = 100'000;  // of 450 landmarks

/// Points in square cells as wide as the tolerance, to count what lies near.
class PointCells {
 public:
  PointCells(const Positions& points, double cell_m) : points_(points), cell_m_(cell_m) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_.emplace(keyOf(points[i], 0, 0), i);
  }

  bool hasNear(const Eigen::Vector2d& p) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto [begin, end] = cells_.equal_range(keyOf(p, dx, dy));
        for (auto it = begin; it != end; ++it) {
          if ((points_[it->second] - p).norm() <= cell_m_) return true;
        }
      }
    }
    return false;
  }

 private:
  std::uint64_t keyOf(const Eigen::Vector2d& p, int dx, int dy) const {
    const auto x = static_cast<std::int64_t>(std::floor(p.x() / cell_m_)) + dx;
    const auto y = static_cast<std::int64_t>(std::floor(p.y() / cell_m_)) + dy;
    return static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15U + static_cast<std::uint64_t>(y);
  }

  const Positions& points_;
  double cell_m_;
  std::unordered_multimap<std::uint64_t, std::size_t> cells_;
};

struct Pair {
  std::size_t first, second;
  double length_m;
};

/// All pairs, longest first, but those that are too short to tell a direction.
std::vector<Pair> pairsOf(const Positions& points, double least_m) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const double length_m = (points[i] - points[j]).norm();
      if (length_m >= least_m) pairs.push_back({i, j, length_m});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(b.length_m, a.first, a.second) < std::tie(a.length_m, b.first, b.second);
  });
  return pairs;
}

/// Evenly chosen of the longer half: long pairs tell the direction best, the longest of all may be
/// of landmarks that are not in the truth.
std::vector<Pair> chosen(const std::vector<Pair>& pairs) {
  const std::size_t half = (pairs.size() + 1) / 2;
  const std::size_t stride = std::max<std::size_t>(1, half / kMostEstimatePairs);
  std::vector<Pair> few;
  for (std::size_t i = 0; i < half; i += stride) few.push_back(pairs[i]);
  return few;
}

std::size_t countFitting(const Pose2& T, const Positions& estimates, const PointCells& truth) {
  return static_cast<std::size_t>(
      std::count_if(estimates.begin(), estimates.end(),
                    [&](const Eigen::Vector2d& p) { return truth.hasNear(T * p); }));
}

Pose2 laidOver(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& true_a,
               const Eigen::Vector2d& true_b) {
  RigidAlignment alignment;
  alignment.add(a, true_a);
  alignment.add(b, true_b);
  return alignment.T_to_from();
}

}  // namespace

std::optional<Pose2> findConstellation(const Positions& estimates, const Positions& truth,
                                       double tolerance_m) {
  const double least_m = 10.0 * tolerance_m;
  const std::vector<Pair> true_pairs = pairsOf(truth, least_m);
  if (true_pairs.size() > kMostTruePairs) return std::nullopt;
  const PointCells cells(truth, tolerance_m);
  std::size_t most = 0;
  Pose2 best;
  for (const Pair& pair : chosen(pairsOf(estimates, least_m))) {
    const auto longer = [&](const Pair& other) {
      return other.length_m > pair.length_m + tolerance_m;
    };
    auto other = std::partition_point(true_pairs.begin(), true_pairs.end(), longer);
    for (; other != true_pairs.end() && other->length_m >= pair.length_m - tolerance_m; ++other) {
      for (const bool swapped : {false, true}) {
        const Pose2 T = laidOver(estimates[pair.first], estimates[pair.second],
                                 truth[swapped ? other->second : other->first],
                                 truth[swapped ? other->first : other->second]);
        const std::size_t fitting = countFitting(T, estimates, cells);
        if (fitting > most) {
          most = fitting;
          best = T;
        }
      }
    }
  }
  const std::size_t needed =
      std::max(kLeastFitting, (std::min(estimates.size(), truth.size()) + 1) / 2);
  return most >= needed ? std::optional<Pose2>(best) : std::nullopt;
}

}  // namespace hymm::core
