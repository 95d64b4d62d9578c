#include "ros/gps_converter.h"

#include <cmath>

#include <sensor_msgs/NavSatStatus.h>

#include "common/gaussian.h"

namespace hymm {
namespace {

std::string problemOf(const sensor_msgs::NavSatFix& message) {
  if (message.status.status < sensor_msgs::NavSatStatus::STATUS_FIX) return "it says 'no fix'";
  if (!(std::abs(message.latitude) <= 90.0) || !std::isfinite(message.longitude)) {
    return "latitude or longitude is not a finite angle in degrees";
  }
  return "";
}

}  // namespace

GpsConverter::Answer GpsConverter::convert(const sensor_msgs::NavSatFix& message) {
  if (const std::string problem = problemOf(message); !problem.empty()) {
    return {std::nullopt, problem};
  }
  core::GpsFix fix;
  fix.time_s = message.header.stamp.toSec();
  fix.antenna = antenna_;
  fix.covariance << message.position_covariance[0], message.position_covariance[1],
      message.position_covariance[3], message.position_covariance[4];
  // Many drivers state a type, and leave the numbers at zero where they do not know them.
  const bool is_told =
      message.position_covariance_type != sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN &&
      !fix.covariance.isZero(0.0);
  if (!is_told) fix.covariance.setIdentity() *= kAssumedDeviation_m * kAssumedDeviation_m;
  if (!core::isCovariance(fix.covariance)) {
    return {std::nullopt, "its covariance is not symmetric and positive definite"};
  }
  const double height_m = std::isfinite(message.altitude) ? message.altitude : 0.0;
  if (!frame_) frame_.emplace(message.latitude, message.longitude, height_m);
  double up_m = 0.0;
  frame_->Forward(message.latitude, message.longitude, height_m, fix.position.x(), fix.position.y(),
                  up_m);
  return {fix, is_told ? ""
                       : "A GPS fix does not tell its covariance (unknown, or zero); 5 m are taken "
                         "for its deviation."};
}

}  // namespace hymm
