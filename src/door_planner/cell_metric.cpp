#include "door_planner/cell_metric.h"

#include <algorithm>
#include <cmath>

#include "door_planner/share_traversal.h"

namespace hymm::core {

CellMetric::CellMetric(const Triangle& triangle, int alpha_cells, int beta_cells,
                       double max_error) {
  const Eigen::Matrix2d edges =
      triangle.edges() * Eigen::Vector2d(1.0 / alpha_cells, 1.0 / beta_cells).asDiagonal();
  squared_ = edges.transpose() * edges;
  // Between two neighbouring steps at an angle t the worst direction is the bisector, along which a
  // path of steps is longer by 1 / cos(t / 2). Halfway round, the sum of both is the next step to
  // take (every whole direction is reached by such sums).
  const double max_angle = 2.0 * std::acos(1.0 / (1.0 + max_error));
  refine({1, 0}, {0, 1}, max_angle);
  refine({0, 1}, {-1, 0}, max_angle);
  const std::size_t half = steps_.size();
  for (std::size_t i = 0; i < half; ++i) addStep({-steps_[i].di, -steps_[i].dj});
}

double CellMetric::angleBetween(const Eigen::Vector2i& u, const Eigen::Vector2i& v) const {
  const Eigen::Vector2d a = u.cast<double>(), b = v.cast<double>();
  const double cosine = a.dot(squared_ * b) / (length(a) * length(b));
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

void CellMetric::refine(const Eigen::Vector2i& u, const Eigen::Vector2i& v, double max_angle) {
  const double angle = angleBetween(u, v);
  if (angle > max_angle) {
    refine(u, u + v, max_angle);
    refine(u + v, v, max_angle);
    return;
  }
  error_ = std::max(error_, 1.0 / std::cos(0.5 * angle) - 1.0);
  addStep(u);
}

void CellMetric::addStep(const Eigen::Vector2i& step) {
  CellStep added;
  added.di = step.x();
  added.dj = step.y();
  added.length_m = length(step.cast<double>());
  const Eigen::Vector2d centre(0.5, 0.5);
  traverseShares(centre, centre + step.cast<double>(), [&](int i, int j, double share) {
    if (share > 0.0) added.passes.push_back({i, j, share});
    return true;
  });
  steps_.push_back(added);
}

}  // namespace hymm::core
