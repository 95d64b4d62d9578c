#include "perception/swept_scan.h"

namespace hymm::core {

LaserScan sweptScan(LaserScan scan, const SweepMotion& motion, const Pose2& T_base_sensor) {
  scan.T_stamp_beam.clear();
  if (scan.sweep_s() == 0.0 || motion.isStill()) return scan;
  scan.T_stamp_beam.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    scan.T_stamp_beam.push_back(motion.sensorPoseAfter(scan.beamTime_s(i), T_base_sensor));
  }
  return scan;
}

}  // namespace hymm::core
