#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>
#include <GeographicLib/LocalCartesian.hpp>
#include <sensor_msgs/NavSatFix.h>

#include "pipeline/sensor_event.h"

namespace hymm {

/// NavSatFix to a local east-north frame whose origin is the first usable fix.
class GpsConverter {
 public:
  struct Answer {
    std::optional<core::GpsFix> fix;
    std::string problem;  ///< why there is none, or what had to be assumed
  };

  /// Deviation of a fix that does not tell its covariance: a usual figure of receivers without
  /// corrections.
  static constexpr double kAssumedDeviation_m = 5.0;

  /// `antenna`: its place in base_link.
  explicit GpsConverter(const Eigen::Vector2d& antenna) : antenna_(antenna) {}

  Answer convert(const sensor_msgs::NavSatFix& message);

  /// The next usable fix is the origin.
  void reset() { frame_.reset(); }

 private:
  Eigen::Vector2d antenna_;
  std::optional<GeographicLib::LocalCartesian> frame_;
};

}  // namespace hymm
