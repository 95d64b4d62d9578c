#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"
#include "pipeline/sensor_event.h"

namespace hymm::core {

/// Brings GPS fixes into the filter. First it collects fixes until those that agree span a
/// baseline, and aligns east and north with the map; from then on T_map_enu is part of the state,
/// and each fix that passes its gate updates it together with everything else. An alignment that no
/// fix confirms is given up.
class GpsDatum {
 public:
  /// `first_state`: index of T_map_enu = (x, y, yaw) among the vehicle's states.
  GpsDatum(const GpsConfig& config, int first_state);

  /// Takes in a fix at the filter's present time. Returns what it did, or nothing if it was not
  /// used.
  std::optional<UpdateOutcome> process(const GpsFix& fix, CompressedEkf& filter);

  bool isAligned() const { return aligned_; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(aligned_, confirmed_, refused_, samples_);
  }

 private:
  struct Sample {
    Eigen::Vector2d antenna_map = Eigen::Vector2d::Zero();
    Eigen::Vector2d fix = Eigen::Vector2d::Zero();
    double variance = 0.0;  ///< of a coordinate of the difference, once they are aligned

    template <class Archive>
    void describeState(Archive& archive) {
      archive(antenna_map, fix, variance);
    }
  };
  class Alignment;
  /// Map's axes turned against east and north.
  struct Turn {
    double yaw_rad = 0.0;
    double variance = 0.0;
  };

  void collect(const GpsFix& fix, const CompressedEkf& filter);
  bool spansBaseline(const std::vector<Sample>& samples) const;
  std::optional<Turn> agreedTurn() const;
  void align(const GpsFix& fix, const Turn& turn, CompressedEkf& filter);
  void noteOutcome(bool used);
  std::optional<UpdateOutcome> update(const GpsFix& fix, CompressedEkf& filter) const;
  Eigen::Matrix2d noiseOf(const GpsFix& fix) const;

  GpsConfig config_;
  int first_state_;
  double gate_;
  bool aligned_ = false;
  bool confirmed_ = false;  ///< a fix was used since
  int refused_ = 0;         ///< fixes since, before that
  std::vector<Sample> samples_;
};

}  // namespace hymm::core
