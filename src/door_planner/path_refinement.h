#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "door_planner/car_space.h"
#include "door_planner/door_graph.h"
#include "door_planner/footprint.h"
#include "door_planner/path_shortening.h"

namespace hymm::core {

/// Makes of a path for a disc one for a car: poses beside the path's corners are joined by shortest
/// curves of the car, so that what they cost together is least; where none is free, RRT* looks for
/// a way within the LTRs that the path crosses and those beside them. What comes of it is
/// shortened.
class PathRefinement {
 public:
  struct Request {
    std::optional<double> start_heading, goal_heading;  ///< in map; nothing: any
    PathShortening::Allows allows;                      ///< where the car may be; may be empty
    std::function<bool()> stop;                         ///< gives up; may be empty
  };

  /// The poses of the car, or a sentence that says why there are none.
  struct Outcome {
    std::vector<CarPose> poses;
    std::string failure;
    int searches = 0;  ///< stretches that were searched by RRT*
  };

  /// `graph` outlives the object.
  PathRefinement(const DoorGraph& graph, const PlannedVehicleConfig& vehicle,
                 const RefinementConfig& config)
      : graph_(graph),
        config_(config),
        footprint_(vehicle),
        space_(vehicle.turning_radius_m, vehicle.can_reverse) {}

  /// Pairs of poses of a way, from far to near, are joined by the shortest curve where that is free
  /// and cheaper, changes of direction included. What was found is kept when it is stopped.
  void shorten(std::vector<CarPose>& poses, const Request& request) const;

  Outcome refine(const std::vector<PathPoint>& path, const Request& request) const;

 private:
  /// A pose that the car may pass, and the cheapest way there.
  struct Option {
    explicit Option(const Pose2& of) : pose(of) {}

    Pose2 pose;
    double cost = kNoPassing;
    int from_station = kNone, from_option = kNone;
    std::vector<CarPose> way;  ///< from there
  };
  /// The start, a corner, or the goal.
  struct Station {
    Eigen::Vector2d place;
    double along_m = 0.0;  ///< of the path, from its start
    std::vector<Option> options;

    bool isReached() const;
    std::size_t cheapest() const;
  };
  struct Run;
  struct Drive;

  std::vector<Station> stationsAlong(const std::vector<PathPoint>& path,
                                     const Request& request) const;
  void addOptions(const Eigen::Vector2d& place, double heading, const Eigen::Vector2d& outwards,
                  const Request& request, Station& station) const;
  void addAnyHeading(const Eigen::Vector2d& place, double heading, const Request& request,
                     Station& station) const;
  bool isFree(const Pose2& pose, const Request& request) const;
  double costOf(const std::vector<CarPose>& way, const Pose2& start, const Request& request) const;
  /// Of a change of direction.
  double changeCost() const { return config_.direction_change_m * graph_.leastPerMetre(); }
  void measure(Drive& drive) const;
  bool cut(Drive& drive, std::size_t from, std::size_t to, const Request& request) const;
  bool reach(std::vector<Station>& stations, std::size_t to, const Request& request) const;
  bool searchTo(std::vector<Station>& stations, std::size_t to, Run& run) const;
  CarSpace::Maze mazeBetween(const std::vector<Station>& stations, std::size_t from, std::size_t to,
                             const Request& request) const;
  std::vector<int> corridorOf(const std::vector<Station>& stations, std::size_t from,
                              std::size_t to) const;
  static std::vector<CarPose> collect(const std::vector<Station>& stations);

  const DoorGraph& graph_;
  RefinementConfig config_;
  Footprint footprint_;
  CarSpace space_;
};

}  // namespace hymm::core
