#include "information_map/exploration_planner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace hymm::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

/// Between two looks at the landmarks on the way, in prediction [m]; a real sensor looks more
/// often.
constexpr double kLookEvery_m = 2.0;

/// Of the vehicle's motion inputs.
constexpr double kInputPeriod_s = 0.1;

/// Weights that covariance intersection tries.
constexpr int kWeights = 10;

double largestDeviation(const Matrix3d& P) {
  const Eigen::Matrix2d position = P.topLeftCorner<2, 2>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(position, Eigen::EigenvaluesOnly)
                       .eigenvalues()(1));
}

}  // namespace

Matrix3d informationOnBase(const Matrix3d& on_sensor, const Pose2& T_map_base,
                           const Pose2& T_base_sensor) {
  const Vector2d lever = T_map_base.rotation() * T_base_sensor.position();
  Matrix3d J = Matrix3d::Identity();  // d(pose of the sensor)/d(pose of base_link)
  J.topRightCorner<2, 1>() << -lever.y(), lever.x();
  return J.transpose() * on_sensor * J;
}

ExplorationPlanner::ExplorationPlanner(const InformationMapConfig& config,
                                       const VehicleConfig& vehicle, const LevelLattice& lattice,
                                       const LevelIslands& islands, const LandmarkField& field,
                                       IsFree is_free, InformationEvaluator::Occlusion hides)
    : config_(config),
      T_base_sensor_(vehicle.laser.T_base_sensor()),
      motion_(vehicle),
      lattice_(lattice),
      islands_(islands),
      field_(field),
      is_free_(std::move(is_free)),
      evaluator_(config.information, std::move(hides)) {}

ExplorationAnswer ExplorationPlanner::suggest(const ExplorationRequest& request) {
  ExplorationAnswer answer;
  level_ = request.level;
  const std::optional<Cell> start = startCell(request);
  if (!start) {
    answer.problem =
        "The vehicle is neither in the level set nor within the sensor's range of it; ask for a "
        "lower value, or drive back to where landmarks are.";
    return answer;
  }
  island_ = islands_.islandOf(lattice_, *start);
  findWays(*start);
  for (const Cell& cell : candidates()) {
    ++answer.candidates;
    ExplorationGoal goal;
    goal.way = wayTo(cell);
    goal.way.insert(goal.way.begin(), request.T_map_base.position());
    predict(request, goal);
    if (exceedsLimits(goal)) continue;
    judge(goal);
    if (goal.new_area_m2 > 0.0) answer.goals.push_back(std::move(goal));
  }
  keepBest(answer.goals);
  if (!answer.goals.empty()) return answer;
  answer.problem = answer.candidates == 0
                       ? "No place at the border can be reached inside the level set."
                       : "Of " + std::to_string(answer.candidates) +
                             " places at the border none can be reached with the deviations that "
                             "are allowed.";
  return answer;
}

bool ExplorationPlanner::exceedsLimits(const ExplorationGoal& goal) const {
  return goal.position_deviation_m > config_.exploration.max_position_deviation_m ||
         goal.heading_deviation_rad > config_.exploration.max_heading_deviation_rad;
}

/// The best first, as many as an answer holds.
void ExplorationPlanner::keepBest(std::vector<ExplorationGoal>& goals) const {
  const double range_m = config_.information.sensor.range_m;
  const auto worth = [range_m](const ExplorationGoal& goal) {
    return goal.new_area_m2 / (goal.way_m + range_m);
  };
  std::stable_sort(
      goals.begin(), goals.end(),
      [&](const ExplorationGoal& a, const ExplorationGoal& b) { return worth(a) > worth(b); });
  const auto most = static_cast<std::size_t>(config_.exploration.max_suggestions);
  if (goals.size() > most) goals.resize(most);
}

/// The cell of the vehicle, or the nearest one of the set within the sensor's range.
std::optional<Cell> ExplorationPlanner::startCell(const ExplorationRequest& request) const {
  const Cell here = lattice_.cellAt(request.T_map_base.position());
  const int most = static_cast<int>(config_.information.sensor.range_m / lattice_.resolution_m());
  std::optional<Cell> nearest;
  int nearest_squared = most * most + 1;
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) {
      const int squared = x * x + y * y;
      if (squared >= nearest_squared || !isInside({here.x + x, here.y + y})) continue;
      nearest = Cell{here.x + x, here.y + y};
      nearest_squared = squared;
    }
  }
  return nearest;
}

/// Dijkstra over the island's cells, eight neighbours each.
void ExplorationPlanner::findWays(const Cell& start) {
  struct Open {
    double way_m;
    Cell cell, from;
    bool operator>(const Open& o) const { return way_m > o.way_m; }
  };
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  reached_.clear();
  open.push({0.0, start, start});
  while (!open.empty()) {
    const Open next = open.top();
    open.pop();
    if (!reached_.try_emplace(keyOf(next.cell), Reached{next.way_m, next.from}).second) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell cell{next.cell.x + dx, next.cell.y + dy};
        if (!isInside(cell) || reached_.count(keyOf(cell)) != 0) continue;
        // Diagonally only between cells that are in the set as well.
        if (dx != 0 && dy != 0 &&
            (!isInside({next.cell.x, cell.y}) || !isInside({cell.x, next.cell.y}))) {
          continue;
        }
        if (is_free_ && !is_free_(lattice_.centre(cell))) continue;
        open.push({next.way_m + lattice_.resolution_m() * std::hypot(dx, dy), cell, next.cell});
      }
    }
  }
}

/// Cells at the border of the island, spacing_m apart, the nearest first.
std::vector<Cell> ExplorationPlanner::candidates() const {
  std::vector<std::pair<double, Cell>> border;
  for (const auto& [key, reached] : reached_) {
    const Cell cell{static_cast<std::int32_t>(key >> 32U), static_cast<std::int32_t>(key)};
    const bool is_border = std::any_of(LevelLattice::kNeighbours.begin(),
                                       LevelLattice::kNeighbours.end(), [&](const Cell& step) {
                                         return !isInside({cell.x + step.x, cell.y + step.y});
                                       });
    if (is_border) border.emplace_back(reached.way_m, cell);
  }
  std::sort(border.begin(), border.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.y, a.second.x) < std::tie(b.first, b.second.y, b.second.x);
  });
  const double squared = config_.exploration.spacing_m * config_.exploration.spacing_m;
  std::vector<Cell> chosen;
  for (const auto& [way_m, cell] : border) {
    const Vector2d place = lattice_.centre(cell);
    const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](const Cell& other) {
      return (lattice_.centre(other) - place).squaredNorm() >= squared;
    });
    if (is_apart) chosen.push_back(cell);
  }
  return chosen;
}

std::vector<Vector2d> ExplorationPlanner::wayTo(const Cell& goal) const {
  std::vector<Vector2d> way;
  Cell cell = goal;
  while (true) {
    way.push_back(lattice_.centre(cell));
    const Cell from = reached_.at(keyOf(cell)).from;
    if (from == cell) break;
    cell = from;
  }
  std::reverse(way.begin(), way.end());
  return way;
}

/// Drives the way in steps between looks at the landmarks.
void ExplorationPlanner::predict(const ExplorationRequest& request, ExplorationGoal& goal) {
  const auto note = [&goal](const Matrix3d& P) {
    goal.position_deviation_m = std::max(goal.position_deviation_m, largestDeviation(P));
    goal.heading_deviation_rad = std::max(goal.heading_deviation_rad, std::sqrt(P(2, 2)));
  };
  Matrix3d P = request.covariance;
  Pose2 pose = request.T_map_base;
  P = fuse(P, informationAt(pose));
  for (std::size_t i = 1; i < goal.way.size(); ++i) {
    const Vector2d leg = goal.way[i] - pose.position();
    const double length_m = leg.norm();
    if (length_m < kLookEvery_m && i + 1 < goal.way.size()) continue;
    if (length_m == 0.0) continue;
    pose.yaw_rad = std::atan2(leg.y(), leg.x());
    P = drive(pose, length_m, P);
    pose = {goal.way[i].x(), goal.way[i].y(), pose.yaw_rad};
    goal.way_m += length_m;
    note(P);
    P = fuse(P, informationAt(pose));
  }
  note(P);
  goal.T_map_base = pose;
}

/// Straight on, in steps as short as an input is trusted.
Matrix3d ExplorationPlanner::drive(Pose2 pose, double length_m, Matrix3d P) const {
  AckermannInput input;
  input.speed_mps = config_.exploration.speed_mps;
  const double duration_s = length_m / input.speed_mps;
  const int steps = static_cast<int>(std::ceil(duration_s / kInputPeriod_s));
  for (int i = 0; i < steps; ++i) {
    const MotionStep step = motion_.step(pose, input, Calibration{}, 0.0, duration_s / steps);
    P = step.J_pose * P * step.J_pose.transpose() + step.noise;
    pose = step.pose;
  }
  return P;
}

Matrix3d ExplorationPlanner::informationAt(const Pose2& T_map_base) {
  return informationOnBase(evaluator_.at(field_, T_map_base * T_base_sensor_).matrix, T_map_base,
                           T_base_sensor_);
}

/// Covariance intersection: consistent whatever the two have in common.
Matrix3d ExplorationPlanner::fuse(const Matrix3d& covariance, const Matrix3d& information) const {
  if (information.isZero(0.0)) return covariance;
  const double length_m = config_.information.length_m;
  const auto size = [length_m](const Matrix3d& P) {
    return P(0, 0) + P(1, 1) + length_m * length_m * P(2, 2);
  };
  // A pose without errors cannot be improved.
  if (!(covariance.determinant() > 0.0)) return covariance;
  const Matrix3d Y = covariance.inverse();
  Matrix3d best = covariance;
  for (int i = 0; i < kWeights; ++i) {
    const double weight = static_cast<double>(i) / kWeights;
    const Matrix3d fused = weight * Y + (1.0 - weight) * information;
    const Eigen::FullPivLU<Matrix3d> lu(fused);
    if (!lu.isInvertible()) continue;
    const Matrix3d P = lu.inverse();
    if (size(P) < size(best)) best = P;
  }
  return 0.5 * (best + best.transpose());
}

/// Area and islands that come into range at the goal.
void ExplorationPlanner::judge(ExplorationGoal& goal) const {
  const double range_m = config_.information.sensor.range_m;
  const Cell centre = lattice_.cellAt(goal.T_map_base.position());
  const int most = static_cast<int>(range_m / lattice_.resolution_m());
  std::size_t outside = 0;
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) {
      if (x * x + y * y > most * most) continue;
      const Cell cell{centre.x + x, centre.y + y};
      if (!isInside(cell)) {
        ++outside;
      } else if (islands_.islandOf(lattice_, cell) != island_) {
        goal.joins_island = islands_.islandOf(lattice_, cell);
      }
    }
  }
  goal.new_area_m2 = static_cast<double>(outside) * lattice_.cellArea_m2();
  for (const Island& island : islands_.islands()) {
    if (island.id != goal.joins_island) continue;
    goal.new_area_m2 += static_cast<double>(island.cells) * lattice_.cellArea_m2();
  }
}

}  // namespace hymm::core
