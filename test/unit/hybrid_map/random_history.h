#pragma once

#include <cmath>
#include <limits>

#include "common/random.h"
#include "hybrid_map/hybrid_map.h"
#include "landmark_maps.h"

namespace hymm::core {

/// A map that lives through random landmarks, corrections, merges, removals and scans.
class RandomHistory {
 public:
  RandomHistory(const HybridMapConfig& config, std::uint64_t seed)
      : map_(config), generator_(seed) {}

  /// Some landmarks appear, move, or go; then a few scans are written. Whether the map took all.
  bool step() {
    const int fresh = static_cast<int>(uniform(0.0, 12.0));
    for (int i = 0; i < fresh; ++i) {
      landmarks_.landmarks.push_back(
          landmarkAt(next_id_++, {uniform(0.0, kSize_m), uniform(0.0, kSize_m)}));
    }
    const double size = std::pow(10.0, uniform(-3.0, 1.5));
    for (auto& landmark : landmarks_.landmarks) {
      landmark.position += Eigen::Vector2d(uniform(-size, size), uniform(-size, size));
    }
    if (landmarks_.landmarks.size() > 2 && uniform(0.0, 1.0) < 0.4) {
      const int last = landmarks_.landmarks.back().id;
      if (uniform(0.0, 1.0) < 0.5) landmarks_.merges.push_back({last, landmarks_.landmarks[0].id});
      landmarks_.landmarks.pop_back();
    }
    ++landmarks_.version;
    correlate(landmarks_);
    bool accepted = map_.apply(landmarks_).accepted;
    for (int i = 0; i < 5; ++i) accepted = map_.insert(randomScan()).accepted && accepted;
    return accepted;
  }

  const HybridMap& map() const { return map_; }
  HybridMap& map() { return map_; }

 private:
  static constexpr double kSize_m = 60.0;

  double uniform(double low, double high) { return sampleUniform(generator_, low, high); }
  PosedScan randomScan() {
    PosedScan posed;
    posed.T_map_laser = {uniform(0.0, kSize_m), uniform(0.0, kSize_m), uniform(-3.0, 3.0)};
    posed.map_version = landmarks_.version;
    posed.scan.angle_increment_rad = 0.05;
    posed.scan.range_max_m = 80.0;
    for (int i = 0; i < 30; ++i) {
      posed.scan.ranges_m.push_back(static_cast<float>(uniform(1.0, 40.0)));
    }
    return posed;
  }

  HybridMap map_;
  RandomGenerator generator_;
  LandmarkMap landmarks_;
  int next_id_ = 0;
};

}  // namespace hymm::core
