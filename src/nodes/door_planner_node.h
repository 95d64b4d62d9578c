#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <hymm/FilterPose.h>
#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>
#include <hymm/LtrGrid.h>
#include <hymm/LtrMap.h>
#include <hymm/PlanPath.h>
#include <hymm/PlanPathAction.h>
#include <nav_msgs/GetPlan.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include "door_planner/door_planner.h"
#include "door_planner/planner_feed.h"
#include "pipeline/landmark_mirror.h"
#include "ros/cause_log.h"
#include "ros/plan_conversions.h"
#include "ros/single_goal_server.h"
#include "ros/traffic_meter.h"
#include "vehicle/vehicle_config.h"

namespace hymm {

/// The node `door_planner`: takes LTRs, their layers and landmarks, answers plan_path and
/// make_plan, and keeps the plan to the last goal in place when the map under it moves. A thread of
/// its own computes doors and cost matrices; requests are answered from others, by the map as it
/// was last prepared.
class DoorPlannerNode {
 public:
  /// Throws ConfigError if the parameters are unusable.
  DoorPlannerNode(const core::DoorPlannerConfig& config, const core::VehicleConfig& vehicle);
  ~DoorPlannerNode();

 private:
  /// What a request asks for, whichever way it came.
  struct Wish {
    std::optional<Eigen::Vector2d> start;  ///< nothing: where the vehicle is
    Eigen::Vector2d goal = Eigen::Vector2d::Zero();
    std::optional<double> start_heading, goal_heading;
    bool is_refined = true;
    double tolerance_m = -1.0;  ///< negative: as configured
    double lowest_information = 0.0;
    std::string weights;
  };
  /// The plan that is kept in place.
  struct LivePlan {
    Wish wish;
    core::Plan plan;
    std::vector<Eigen::Vector2d> sent;  ///< as it was last published
  };
  using PlanServer = SingleGoalServer<PlanPathAction>;

  void takeMap(const LandmarkMap& message);
  void takeUpdate(const LandmarkUpdate& message);
  void takeLtrs(const LtrMap& message);
  void takeGrid(const LtrGrid& message);
  void takePose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void takeFilterPose(const FilterPose& message);
  void takeLevelSet(const LevelSet& message);
  void takeGoal(const geometry_msgs::PoseStamped& message);
  bool planPath(PlanPath::Request& request, PlanPath::Response& response);
  bool makePlan(nav_msgs::GetPlan::Request& request, nav_msgs::GetPlan::Response& response);
  PlanServer::End executeAction(const PlanPathGoal& goal);

  core::Plan plan(const Wish& wish, const std::function<bool()>& cancelled = nullptr);
  /// Adds where the plan begins and where it may lead, by what has come. A refusal where that is
  /// too little.
  std::optional<core::Plan> addWhatIsKnown(const Wish& wish, core::PlanRequest& request);
  bool isOurFrame(const std::string& frame, const std::string& topic);
  void listenForRestart();
  void beginMap();
  std::size_t mapsBegun();
  void follow(const core::LandmarkMap& map);
  /// `maps_begun`: as it was before the plan was made.
  void keep(const Wish& wish, const core::Plan& plan, std::size_t maps_begun);
  /// Lets the worker look whether the plan kept is blocked: the map may have changed meanwhile.
  void watch();
  void publishLive(LivePlan& live);
  void work();
  void workOn();
  void prepareDistricts();
  void replanIfBlocked();
  void tellUnusable();
  void publishDoors();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  std_msgs::Header header() const;

  core::DoorPlannerConfig config_;
  std::string map_frame_;
  CauseLog causes_;
  TrafficMeter traffic_;
  core::DoorPlanner planner_;

  std::mutex mutex_;  ///< over what follows; never held while the planner computes
  std::condition_variable changed_;
  core::PlannerFeed feed_;
  core::LandmarkMirror mirror_;
  core::FilterLife filter_;          ///< by its poses
  std::size_t filter_restarts_ = 0;  ///< as the plan knows them
  std::size_t maps_begun_ = 0;       ///< by the filter: each time landmark ids start again
  std::optional<core::Pose2> vehicle_;
  std::map<double, std::shared_ptr<const InformedPlaces>> level_sets_;  ///< by value
  std::optional<LivePlan> live_;
  std::map<std::string, std::size_t> answers_;  ///< by status
  std::set<core::LtrProblem> told_problems_;
  std::size_t blocked_plans_ = 0;
  bool has_news_ = false, stopping_ = false;
  double preparation_ms_ = 0.0, answer_ms_ = 0.0, worst_answer_ms_ = 0.0;
  core::DoorMap::Counts counts_;
  double doors_sent_s_ = -1.0;

  ros::NodeHandle handle_;
  ros::CallbackQueue request_queue_;
  ros::NodeHandle request_handle_;
  ros::Publisher plan_publisher_, doors_publisher_;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  std::unique_ptr<PlanServer> action_;
  ros::AsyncSpinner request_spinner_;
  diagnostic_updater::Updater diagnostics_;
  ros::SteadyTimer diagnostics_timer_;
  std::thread worker_;
};

}  // namespace hymm
