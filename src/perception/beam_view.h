#pragma once

#include <cmath>
#include <cstdlib>

#include "common/angles.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// What one beam of a scan says.
enum class BeamKind {
  kHit,      ///< a range within the sensor's limits
  kFree,     ///< nothing within range
  kTooNear,  ///< something closer than the sensor can measure
  kUnknown   ///< no measurement
};

/// A scan as a ring or row of beams, seen without copying. On a full turn indices go around; a
/// beam that a driver repeats at the end of the turn is left out. Where beams are measured one
/// after another the turn is not closed: between its last beam and its first the sensor has moved.
class BeamView {
 public:
  explicit BeamView(const LaserScan& scan)
      : scan_(scan),
        size_(static_cast<int>(scan.ranges_m.size())),
        is_swept_(scan.sweep_s() > 0.0) {
    const double turn = 2.0 * kPi / spacing();  // beams of a full turn
    full_turn_ = size_ > 2 && size_ >= turn - 0.5 && !is_swept_;
    if (full_turn_) size_ = static_cast<int>(std::lround(turn));
  }

  int size() const { return size_; }
  bool fullTurn() const { return full_turn_; }
  bool hasIntensities() const { return !scan_.intensities.empty(); }
  double increment() const { return scan_.angle_increment_rad; }
  double spacing() const { return std::abs(scan_.angle_increment_rad); }

  /// Whether `index`, which may run past either end, is a beam of the scan.
  bool contains(int index) const { return full_turn_ || (index >= 0 && index < size_); }

  double range(int index) const { return static_cast<double>(scan_.ranges_m[place(index)]); }
  double intensity(int index) const { return static_cast<double>(scan_.intensities[place(index)]); }

  /// Of a place between beams, too; not wrapped.
  double bearing(double index) const {
    return scan_.angle_min_rad + index * scan_.angle_increment_rad;
  }

  /// When a place between beams, too, was measured, after the scan's stamp.
  double afterStamp_s(double index) const {
    if (!is_swept_) return 0.0;
    const double before = std::floor(index), share = index - before;
    const double before_s = scan_.beamTime_s(place(static_cast<int>(before)));
    if (share == 0.0) return before_s;
    return before_s + share * (scan_.beamTime_s(place(static_cast<int>(before) + 1)) - before_s);
  }

  BeamKind kind(int index) const {
    const double r = range(index);
    if (std::isnan(r)) return BeamKind::kUnknown;
    if (std::isinf(r)) return r > 0.0 ? BeamKind::kFree : BeamKind::kTooNear;
    if (r >= scan_.range_max_m) return BeamKind::kFree;
    // A range of zero, or under the sensor's limit, is how many drivers say "no measurement".
    return r > 0.0 && r >= scan_.range_min_m ? BeamKind::kHit : BeamKind::kUnknown;
  }

 private:
  std::size_t place(int index) const {
    if (index >= 0 && index < size_) return static_cast<std::size_t>(index);
    return static_cast<std::size_t>((index % size_ + size_) % size_);
  }

  const LaserScan& scan_;
  int size_;
  bool is_swept_;
  bool full_turn_ = false;
};

}  // namespace hymm::core
