#pragma once

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/landmark_registry.h"
#include "common/pose2.h"
#include "perception/laser_scan.h"

namespace hymm::core {

/// Whether a scan should have shown a landmark at `position_at_stamp` (from where the
/// sensor was then): within its range of
/// visibility, inside the field of view, and with beams that pass its place. A landmark that
/// something nearer hides is not expected.
bool shouldBeVisible(const LaserScan& scan, const Eigen::Vector2d& position_at_stamp,
                     const RegisteredLandmark& landmark, const LandmarkConfig& config);

}  // namespace hymm::core
