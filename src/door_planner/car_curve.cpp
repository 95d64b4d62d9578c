#include "door_planner/car_curve.h"

#include <cmath>

namespace hymm::core {

Pose2 advance(const Pose2& T_map_base, const CurvePiece& piece) {
  const double turn = piece.curvature * piece.length_m;
  // The chord of an arc halves its angle; sin(x) / x is 1 for a straight line.
  const double half = 0.5 * turn;
  const double chord = piece.length_m * (std::abs(half) < 1e-9 ? 1.0 : std::sin(half) / half);
  return T_map_base * Pose2{chord * std::cos(half), chord * std::sin(half), turn};
}

double CarCurve::length() const {
  double sum = 0.0;
  for (const CurvePiece& piece : pieces) sum += std::abs(piece.length_m);
  return sum;
}

int CarCurve::directionChanges() const {
  int changes = 0;
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    changes += pieces[i].length_m * pieces[i - 1].length_m < 0.0 ? 1 : 0;
  }
  return changes;
}

std::vector<CarPose> CarCurve::poses(double step_m) const {
  std::vector<CarPose> poses;
  Pose2 begin = start;
  for (const CurvePiece& piece : pieces) {
    const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(piece.length_m) / step_m)));
    for (int k = 1; k <= parts; ++k) {
      poses.push_back(
          {advance(begin, {piece.curvature, piece.length_m * k / parts}), piece.length_m < 0.0});
    }
    begin = poses.back().T_map_base;
  }
  if (!poses.empty()) poses.back().T_map_base = end;
  return poses;
}

}  // namespace hymm::core
