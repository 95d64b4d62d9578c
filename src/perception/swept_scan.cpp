#include "perception/swept_scan.h"

namespace hymm::core {

LaserScan sweptScan(LaserScan scan, const SweepMotion& motion, const Pose2& T_base_sensor) {
  scan.T_stamp_beam.clear();
  if (scan.sweep_s() == 0.0 || motion.isStill()) return scan;
  scan.T_stamp_beam.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double after_s = static_cast<double>(i) * scan.time_increment_s;
    scan.T_stamp_beam.push_back(motion.sensorPoseAfter(after_s, T_base_sensor));
  }
  return scan;
}

}  // namespace hymm::core
