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
constexpr double kStride_m = 0.05;  ///< at which distances to what stands there are asked for
constexpr int kRim = 16;            ///< places on the rim of a disc of the vehicle's width
constexpr double kSlack_m = 0.02;   ///< headings come from chords

Eigen::Vector2d placeIn(const DoorGraph& graph, RandomGenerator& generator) {
  const auto number = static_cast<std::size_t>(
      sampleUniform(generator, 0.0, static_cast<double>(graph.ltrs().size())));
  Triangle::Local local(sampleUniform(generator, 0.0, 1.0), sampleUniform(generator, 0.0, 1.0));
  if (local.sum() > 1.0) local = Triangle::Local::Ones() - local;
  return graph.ltrs()[number].triangle.toGlobal(local);
}

class Checker {
 public:
  Checker(const DoorPlanner& planner, const HybridMap& map, const LandmarkMap& landmarks)
      : planner_(planner), map_(map), standing_(map, landmarks.landmarks, planner.config()) {}

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

  /// Least distance of the rims of the vehicle's discs, one for the path of a disc, to what stands
  /// on the ground; below 0 they touch.
  double clearance_m(const Plan& plan) const {
    const PlannedVehicleConfig& vehicle = planner_.config().vehicle;
    const std::vector<double> centres =
        plan.is_refined ? Footprint(vehicle).centres() : std::vector<double>{0.0};
    double least = StandingObjects::kFar_m;
    for (std::size_t k = 0; k < plan.path.size(); ++k) {
      const Pose2 pose{plan.path[k].x(), plan.path[k].y(), headingAt(plan, k)};
      const Eigen::Vector2d along =
          k == 0 ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(plan.path[k - 1] - plan.path[k]);
      const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / kStride_m)));
      for (int part = 0; part < parts; ++part) {
        for (const double centre : centres) {
          const Eigen::Vector2d place = pose * Eigen::Vector2d(centre, 0.0) + along * part / parts;
          least = std::min(least, standing_.distance_m(place) - 0.5 * vehicle.width_m);
        }
      }
    }
    return least;
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
  StandingObjects standing_;
};

/// A plan, and the CPU time that it took.
std::pair<Plan, double> timed(const DoorPlanner& planner, const PlanRequest& request) {
  const double before_s = threadCpuTime_s();
  Plan plan = planner.plan(request);
  return {std::move(plan), 1e3 * (threadCpuTime_s() - before_s)};
}

}  // namespace

StandingObjects::StandingObjects(const HybridMap& map,
                                 const std::vector<LandmarkEstimate>& landmarks,
                                 const DoorPlannerConfig& config)
    : index_(kFar_m) {
  for (const LandmarkEstimate& landmark : landmarks) {
    const double diameter_m =
        std::isfinite(landmark.diameter_m) ? landmark.diameter_m : config.landmark_diameter_m;
    add(landmark.position, 0.5 * diameter_m);
  }
  const double occupied = config.cost.occupied_probability;
  const double threshold = std::log(occupied / (1.0 - occupied));
  map.waiting().visitTiles(LayerSet::kOccupancy, [&](const WaitingTile& tile) {
    std::vector<float> buffer;
    const std::vector<float>& cells = tile.cells->peek(LayerSet::kOccupancy, buffer);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (static_cast<double>(cells[i]) < threshold) continue;
      const Eigen::Vector2d centre(static_cast<double>(i % WaitingTile::kCells) + 0.5,
                                   static_cast<double>(i / WaitingTile::kCells) + 0.5);
      const Eigen::Vector2d place = tile.T_map_cells * (tile.resolution_m * centre);
      if (map.partition().mesh().locate(place) == kNone) add(place, 0.0);
    }
  });
}

void StandingObjects::add(const Eigen::Vector2d& place, double radius_m) {
  const Eigen::Vector2d radius = Eigen::Vector2d::Constant(radius_m);
  index_.place(static_cast<int>(discs_.size()), place - radius, place + radius);
  discs_.push_back({place, radius_m});
}

double StandingObjects::distance_m(const Eigen::Vector2d& place) const {
  double least = kFar_m;
  const Eigen::Vector2d far = Eigen::Vector2d::Constant(kFar_m);
  index_.visit(place - far, place + far, [&](int number) {
    const Disc& disc = discs_[std::size_t(number)];
    least = std::min(least, (disc.place - place).norm() - disc.radius_m);
  });
  return least;
}

std::string checkQueries(const DoorPlanner& planner, const HybridMap& map,
                         const LandmarkMap& landmarks, int queries) {
  const Checker checker(planner, map, landmarks);
  const std::shared_ptr<const DoorGraph> graph = planner.graph();
  RandomGenerator generator(1);
  std::string text =
      "start_x,start_y,goal_x,goal_y,status,cost,length_m,milliseconds,occupied_m,refined,"
      "refined_length_m,refined_milliseconds,refined_occupied_m,tightest_radius_m,touching_poses,"
      "clearance_m,"
      "refined_clearance_m\n";
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
                    car.is_refined ? checker.touches(car) : 0, checker.clearance_m(plan),
                    checker.clearance_m(car)) +
            "\n";
  }
  return text;
}

}  // namespace hymm::core
