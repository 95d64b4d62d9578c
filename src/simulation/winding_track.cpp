#include "simulation/winding_track.h"

#include <cmath>
#include <vector>

namespace hymm::core {

Route windingTrack(double length_m, RandomGenerator& generator) {
  constexpr int kPoints = 2000;
  std::vector<double> amplitude, phase;
  for (const double greatest : {0.30, 0.15, 0.07}) {
    amplitude.push_back(sampleUniform(generator, 0.6 * greatest, greatest));
    phase.push_back(sampleUniform(generator, -kPi, kPi));
  }
  std::vector<Eigen::Vector2d> points;
  double length = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * kPi * i / kPoints;
    double radius = 1.0;
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      radius += amplitude[k] * std::cos(static_cast<double>(k + 2) * angle + phase[k]);
    }
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    if (i > 0) length += (points.back() - points[points.size() - 2]).norm();
  }
  length += (points.front() - points.back()).norm();
  for (Eigen::Vector2d& point : points) point *= length_m / length;
  return Route(points);
}

Roadside::Roadside(const Route& route, double reach_m) : reach_m_(reach_m) {
  for (const Eigen::Vector2d& point : route.points()) bounds_.extend(point);
  bounds_.extend(bounds_.min() - Eigen::Vector2d::Constant(reach_m));
  bounds_.extend(bounds_.max() + Eigen::Vector2d::Constant(reach_m));
}

Eigen::Vector2d Roadside::sample(const WorldBuilder& builder, RandomGenerator& generator) const {
  while (true) {
    const Eigen::Vector2d point(sampleUniform(generator, bounds_.min().x(), bounds_.max().x()),
                                sampleUniform(generator, bounds_.min().y(), bounds_.max().y()));
    if (builder.distanceFromRoute(point, reach_m_) < reach_m_) return point;
  }
}

}  // namespace hymm::core
