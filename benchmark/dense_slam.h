#pragma once

#include <unordered_map>
#include <vector>

#include "benchmark/dense_ekf.h"
#include "benchmark/plain_drive.h"
#include "vehicle/motion_model.h"

namespace hymm::benchmarks {

/// Landmark SLAM with the dense EKF: the same motion model, measurements and states as hymm's
/// filter. Associations are told to it, so that it spends no time on them.
class DenseSlam {
 public:
  DenseSlam(const core::VehicleConfig& vehicle, int landmarks);

  /// Moves to the scan's time and takes in its observations.
  void process(const ScanPeriod& period);

  core::Pose2 pose() const { return core::Pose2::fromVector(filter_.vehicle().head<3>()); }
  int landmarkCount() const { return filter_.landmarkCount(); }

 private:
  void moveTo(double time_s);
  void observe(const core::ObservationSet& set, const std::vector<int>& identities);

  core::MotionModel model_;
  DenseEkf filter_;
  core::MotionInput input_;
  double time_s_ = 0.0;
  bool started_ = false;
  std::unordered_map<int, int> landmark_of_identity_;
};

}  // namespace hymm::benchmarks
