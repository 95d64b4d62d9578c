#include "evaluation/gps_error.h"

#include <utility>

#include "evaluation/fix_gate.h"
#include "evaluation/rigid_alignment.h"

namespace hymm::core {
namespace {

// A rigid motion has three parameters: two fixes determine it and say nothing about errors.
constexpr std::size_t kFewestFixes = 3;

}  // namespace

std::optional<GpsErrors> computeGpsErrors(const Trajectory& T_map_base,
                                          const std::vector<StampedPosition>& fixes,
                                          const Eigen::Vector2d& p_base_antenna,
                                          const TimeWindow& window) {
  GpsErrors errors;
  FixGate gate;
  RigidAlignment alignment;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> pairs;  // map, GPS
  for (const StampedPosition& fix : fixes) {
    const bool is_kept = gate.keep(fix.time_s, fix.position);
    if (!window.contains(fix.time_s)) continue;
    if (!is_kept) {
      ++errors.unreachable;
      continue;
    }
    const std::optional<Pose2> pose = T_map_base.at(fix.time_s);
    if (!pose) {
      ++errors.without_pose;
      continue;
    }
    pairs.emplace_back(*pose * p_base_antenna, fix.position);
    alignment.add(pairs.back().first, pairs.back().second);
  }
  if (pairs.size() < kFewestFixes) return std::nullopt;
  errors.T_gps_map = alignment.T_to_from();
  std::vector<double> distances;
  distances.reserve(pairs.size());
  for (const auto& [map, gps] : pairs) distances.push_back((errors.T_gps_map * map - gps).norm());
  errors.distance_m = errorStatistics(std::move(distances));
  return errors;
}

}  // namespace hymm::core
