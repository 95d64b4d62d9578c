#include "pipeline/plan_check.h"

#include <algorithm>
#include <cmath>

#include "common/cpu_timer.h"
#include "common/random.h"
#include "door_planner/footprint.h"
#include "pipeline/csv_line.h"

namespace hymm::core {
namespace {

constexpr double kEvery_m = 0.01;
constexpr int kRim = 16;           ///< places on the rim of a disc of the vehicle's width
constexpr double kSlack_m = 0.02;  ///< headings come from chords

Eigen::Vector2d placeIn(const DoorGraph& graph, RandomGenerator& generator) {
  const auto number = static_cast<std::size_t>(
      sampleUniform(generator, 0.0, static_cast<double>(graph.ltrs().size())));
  Triangle::Local local(sampleUniform(generator, 0.0, 1.0), sampleUniform(generator, 0.0, 1.0));
  if (local.sum() > 1.0) local = Triangle::Local::Ones() - local;
  return graph.ltrs()[number].triangle.toGlobal(local);
}

class Checker {
 public:
  Checker(const DoorPlanner& planner, const HybridMap& map) : planner_(planner), map_(map) {}

  bool isOccupied(const Eigen::Vector2d& place) const {
    const LayerQuery query = map_.query("occupancy", place);
    return query.value && query.value->value >= planner_.config().cost.occupied_probability;
  }

  /// Length of a path's line in occupied cells.
  double occupied_m(const Plan& plan) const {
    double sum = 0.0;
    for (std::size_t k = 1; k < plan.path.size(); ++k) {
      const Eigen::Vector2d along = plan.path[k] - plan.path[k - 1];
      const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / kEvery_m)));
      for (int part = 0; part < parts; ++part) {
        if (isOccupied(plan.path[k - 1] + along * (part + 0.5) / parts)) sum += kEvery_m;
      }
    }
    return sum;
  }

  /// Number of poses in which the vehicle's discs reach into an occupied cell.
  int touches(const Plan& plan) const {
    const PlannedVehicleConfig& vehicle = planner_.config().vehicle;
    const Footprint footprint(vehicle);
    int count = 0;
    for (std::size_t i = 0; i < plan.path.size(); ++i) {
      const Pose2 pose{plan.path[i].x(), plan.path[i].y(), headingAt(plan, i)};
      bool touches = false;
      for (std::size_t k = 0; k < kRim * footprint.centres().size() && !touches; ++k) {
        const double angle = 2.0 * M_PI * static_cast<double>(k) / kRim;
        const double radius = 0.5 * vehicle.width_m - kSlack_m;
        touches = isOccupied(
            pose * Eigen::Vector2d(footprint.centres()[k / kRim] + radius * std::cos(angle),
                                   radius * std::sin(angle)));
      }
      count += touches ? 1 : 0;
    }
    return count;
  }

 private:
  const DoorPlanner& planner_;
  const HybridMap& map_;
};

/// A plan, and the CPU time that it took.
std::pair<Plan, double> timed(const DoorPlanner& planner, const PlanRequest& request) {
  const double before_s = threadCpuTime_s();
  Plan plan = planner.plan(request);
  return {std::move(plan), 1e3 * (threadCpuTime_s() - before_s)};
}

}  // namespace

std::string checkQueries(const DoorPlanner& planner, const HybridMap& map, int queries) {
  const Checker checker(planner, map);
  const std::shared_ptr<const DoorGraph> graph = planner.graph();
  RandomGenerator generator(1);
  std::string text =
      "start_x,start_y,goal_x,goal_y,status,cost,length_m,milliseconds,occupied_m,refined,"
      "refined_length_m,refined_milliseconds,refined_occupied_m,tightest_radius_m,touching_poses\n";
  for (int i = 0; i < queries && !graph->ltrs().empty(); ++i) {
    PlanRequest request;
    request.start = placeIn(*graph, generator);
    request.goal = placeIn(*graph, generator);
    const auto [plan, plan_ms] = timed(planner, request);
    request.is_refined = true;
    const auto [car, car_ms] = timed(planner, request);
    text += csvLine(',', request.start.x(), request.start.y(), request.goal.x(), request.goal.y(),
                    nameOf(plan.status), plan.cost, plan.length_m, plan_ms,
                    checker.occupied_m(plan), car.is_refined ? 1 : 0, car.length_m, car_ms,
                    checker.occupied_m(car), car.is_refined ? tightestRadius_m(car) : 0.0,
                    car.is_refined ? checker.touches(car) : 0) +
            "\n";
  }
  return text;
}

}  // namespace hymm::core
