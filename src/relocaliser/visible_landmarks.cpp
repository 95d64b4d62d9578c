#include "relocaliser/visible_landmarks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace hymm::core {
namespace {

// Particles are gathered in squares of this size; a landmark is tested against squares.
constexpr double kSquare_m = 2.0;
constexpr double kDeviations = 4.0;

// A particle with less weight than this, against the heaviest, stands nowhere.
constexpr float kLeastLogWeight = -30.0F;

std::vector<Eigen::Vector2d> occupiedSquares(const ParticleSet& particles) {
  std::set<std::pair<int, int>> squares;
  std::pair<int, int> last;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!(particles.log_weight[i] > kLeastLogWeight)) continue;
    const std::pair<int, int> square(
        static_cast<int>(std::floor(static_cast<double>(particles.x_m[i]) / kSquare_m)),
        static_cast<int>(std::floor(static_cast<double>(particles.y_m[i]) / kSquare_m)));
    if (square != last || squares.empty()) squares.insert(square);
    last = square;
  }
  std::vector<Eigen::Vector2d> centres;
  for (const auto& [x, y] : squares) {
    centres.emplace_back(kSquare_m * (x + 0.5), kSquare_m * (y + 0.5));
  }
  return centres;
}

}  // namespace

std::vector<LocalLandmark> findVisibleLandmarks(const ParticleSet& particles,
                                                const std::vector<ObservedPoint>& points,
                                                const std::vector<LocalLandmark>& landmarks) {
  double farthest_m = 0.0, deviation_m = 0.0;
  for (const ObservedPoint& point : points) {
    farthest_m = std::max(farthest_m, static_cast<double>(point.p_base_point.norm()));
    deviation_m = std::max(deviation_m, point.deviation_m);
  }
  const std::vector<Eigen::Vector2d> squares = occupiedSquares(particles);
  std::vector<LocalLandmark> visible;
  for (const LocalLandmark& landmark : landmarks) {
    const double reach_m =
        farthest_m + kSquare_m +
        kDeviations * std::sqrt(landmark.covariance.trace() + deviation_m * deviation_m);
    const auto isNear = [&](const Eigen::Vector2d& centre) {
      return (centre - landmark.position).squaredNorm() <= reach_m * reach_m;
    };
    if (std::any_of(squares.begin(), squares.end(), isNear)) visible.push_back(landmark);
  }
  return visible;
}

}  // namespace hymm::core
