#include "simulation/route_follower.h"

#include <algorithm>
#include <cmath>

namespace hymm::core {
namespace {

constexpr double kShortestLookahead_m = 3.0;
constexpr double kLookahead_s = 0.8;
constexpr double kSlowest_mps = 0.2;  // so that the car starts, and arrives

}  // namespace

RouteFollower::RouteFollower(const Route& route, const DriveConfig& drive,
                             const VehicleConfig& vehicle, double speed_mps)
    : route_(route),
      drive_(drive),
      wheelbase_m_(vehicle.ackermann.wheelbase_m),
      max_steering_rad_(vehicle.max_steering_rad),
      end_m_(route.length_m() * drive.laps) {
  limitSpeeds(drive.speed_mps > 0.0 ? drive.speed_mps : speed_mps);
}

/// What curves allow, and what can be braked from before them.
void RouteFollower::limitSpeeds(double speed_mps) {
  const std::size_t n = route_.points().size();
  const double step = route_.length_m() / static_cast<double>(n);
  speed_limits_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double curvature = std::abs(route_.curvature(step * static_cast<double>(i)));
    const double in_curve = std::sqrt(drive_.lateral_acceleration_mps2 / std::max(curvature, 1e-6));
    speed_limits_[i] = std::min(speed_mps, in_curve);
  }
  for (std::size_t k = 2 * n; k > 0; --k) {  // twice around, backwards
    const double next = speed_limits_[k % n];
    double& limit = speed_limits_[(k - 1) % n];
    limit = std::min(limit, std::sqrt(next * next + 2.0 * drive_.acceleration_mps2 * step));
  }
}

double RouteFollower::speedLimit(double along_m) const {
  const double share = std::fmod(along_m, route_.length_m()) / route_.length_m();
  const auto n = speed_limits_.size();
  const auto i = std::min(static_cast<std::size_t>(share * static_cast<double>(n)), n - 1);
  const double to_go = std::max(0.0, end_m_ - along_m);
  return std::min(speed_limits_[i], std::sqrt(2.0 * drive_.acceleration_mps2 * to_go));
}

RouteFollower::Command RouteFollower::follow(const Pose2& T_route_base, const Command& last,
                                             double duration_s) {
  const double reach = 1.0 + 2.0 * last.speed_mps * duration_s;
  along_m_ = route_.nearest(T_route_base.position(), along_m_, along_m_ + reach);
  const double lookahead = std::max(kShortestLookahead_m, kLookahead_s * last.speed_mps);
  const Eigen::Vector2d target = inverse(T_route_base) * route_.at(along_m_ + lookahead).position();
  const double curvature = 2.0 * target.y() / target.squaredNorm();
  const double wanted =
      std::clamp(std::atan(wheelbase_m_ * curvature), -max_steering_rad_, max_steering_rad_);

  const double turn = drive_.steering_rate_radps * duration_s;
  const double gain = drive_.acceleration_mps2 * duration_s;
  Command command;
  command.steering_rad = last.steering_rad + std::clamp(wanted - last.steering_rad, -turn, turn);
  const double allowed = std::max(kSlowest_mps, speedLimit(along_m_));
  command.speed_mps = std::min(allowed, last.speed_mps + gain);
  return command;
}

}  // namespace hymm::core
