#pragma once

#include <cstddef>
#include <vector>

#include "common/pose2.h"

namespace hymm::core {

/// Poses with weights, one array for each coordinate, so that loops over them use the whole width
/// of the machine. Floats: in a local frame their rounding is below a tenth of a millimetre.
struct ParticleSet {
  std::vector<float> x_m;
  std::vector<float> y_m;
  std::vector<float> yaw_rad;     ///< not wrapped
  std::vector<float> log_weight;  ///< up to a common constant
  std::vector<float> weight;      ///< as normaliseWeights() left it: the greatest is 1

  std::size_t size() const { return x_m.size(); }
  void resize(std::size_t count) {
    for (auto* column : {&x_m, &y_m, &yaw_rad, &log_weight, &weight}) column->resize(count);
  }
  void reserve(std::size_t count) {
    for (auto* column : {&x_m, &y_m, &yaw_rad, &log_weight, &weight}) column->reserve(count);
  }
  void add(const Pose2& pose, float log_weight_of_it = 0.0F) {
    x_m.push_back(static_cast<float>(pose.x_m));
    y_m.push_back(static_cast<float>(pose.y_m));
    yaw_rad.push_back(static_cast<float>(pose.yaw_rad));
    log_weight.push_back(log_weight_of_it);
    weight.push_back(1.0F);
  }
  Pose2 pose(std::size_t i) const {
    return {static_cast<double>(x_m[i]), static_cast<double>(y_m[i]),
            wrapAngle(static_cast<double>(yaw_rad[i]))};
  }
};

}  // namespace hymm::core
