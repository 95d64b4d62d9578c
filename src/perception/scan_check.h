#pragma once

#include <optional>
#include <string>

#include "perception/laser_scan.h"

namespace hymm::core {

/// What makes a scan unusable, as a sentence that names the field and its value: a stamp or angle
/// that is not finite, an increment of zero, range limits out of order, no ranges, intensities or
/// times of beams of another length, such times beyond LaserScan::kLongestSweep_s. Single invalid
/// ranges (NaN, negative) do not; they count as no measurement.
std::optional<std::string> scanProblem(const LaserScan& scan);

/// Why the time increment of a scan is not used, as a sentence: it is not finite or negative, says
/// that the scan takes longer than LaserScan::kLongestSweep_s, or clearly longer than the time from
/// scan to scan, `scan_time_s` (0: not told). The scan's beams are then taken as of one instant.
std::optional<std::string> sweepProblem(const LaserScan& scan, double scan_time_s);

/// Beams whose range REP-117 gives no meaning to: NaN is allowed there, negative ranges are not.
std::size_t invalidRanges(const LaserScan& scan);

}  // namespace hymm::core
