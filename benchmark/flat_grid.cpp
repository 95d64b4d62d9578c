#include "benchmark/flat_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "hybrid_map/log_odds.h"
#include "hybrid_map/written_beam.h"

namespace hymm::benchmarks {

FlatGrid::FlatGrid(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution_m,
                   const core::OccupancyConfig& config)
    : config_(config),
      low_((low / resolution_m).array().floor() * resolution_m),
      cells_per_m_(1.0 / resolution_m),
      width_(static_cast<int>(std::ceil((high - low).x() / resolution_m))),
      height_(static_cast<int>(std::ceil((high - low).y() / resolution_m))),
      hit_(static_cast<float>(core::logOddsOf(config.hit_probability))),
      miss_(static_cast<float>(core::logOddsOf(config.miss_probability))),
      least_(static_cast<float>(core::logOddsOf(config.min_probability))),
      most_(static_cast<float>(core::logOddsOf(config.max_probability))),
      cells_(std::size_t(width_) * std::size_t(height_), 0.0F) {}

void FlatGrid::clear() { std::fill(cells_.begin(), cells_.end(), 0.0F); }

core::OccupancyImage FlatGrid::image() const {
  core::OccupancyImage image;
  image.resolution_m = 1.0 / cells_per_m_;
  image.corner = (low_ * cells_per_m_).array().round().cast<int>();
  image.width = width_;
  image.height = height_;
  image.cells.resize(cells_.size());
  std::transform(cells_.begin(), cells_.end(), image.cells.begin(), core::occupancyPercent);
  return image;
}

std::size_t FlatGrid::insert(const core::LaserScan& scan, const core::Pose2& T_map_laser) {
  std::size_t beams = 0;
  const Eigen::Vector2d start = (T_map_laser.position() - low_) * cells_per_m_;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const std::optional<core::WrittenBeam> written = core::writtenBeam(scan, i, config_);
    if (!written) continue;
    const double bearing = T_map_laser.yaw_rad + scan.bearing(i);
    const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
    writeBeam(start, start + cells_per_m_ * written->length_m * along, written->is_hit);
    ++beams;
  }
  return beams;
}

// All cells that the line passes, in order (Amanatides and Woo, 1987), with one index that is
// carried along.
void FlatGrid::writeBeam(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hits) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d along = to - from;
  const int i = static_cast<int>(from.x()), j = static_cast<int>(from.y());
  const int last_i = static_cast<int>(to.x()), last_j = static_cast<int>(to.y());
  if (std::min({i, j, last_i, last_j}) < 0 || std::max(i, last_i) >= width_ ||
      std::max(j, last_j) >= height_) {
    std::abort();  // the benchmark's world has room for all beams
  }
  const int step_i = last_i > i ? 1 : -1, step_j = last_j > j ? width_ : -width_;
  double next_i = i == last_i ? kNever : (i + (step_i > 0) - from.x()) / along.x();
  double next_j = j == last_j ? kNever : (j + (step_j > 0) - from.y()) / along.y();
  const double per_i = std::abs(1.0 / along.x()), per_j = std::abs(1.0 / along.y());
  float* cell = &cells_[std::size_t(j) * std::size_t(width_) + std::size_t(i)];
  const float miss = miss_, least = least_;
  for (int steps = std::abs(last_i - i) + std::abs(last_j - j); steps > 0; --steps) {
    *cell = std::max(*cell + miss, least);
    if (next_i < next_j) {
      cell += step_i;
      next_i += per_i;
    } else {
      cell += step_j;
      next_j += per_j;
    }
  }
  *cell = hits ? std::min(*cell + hit_, most_) : std::max(*cell + miss, least);
}

}  // namespace hymm::benchmarks
