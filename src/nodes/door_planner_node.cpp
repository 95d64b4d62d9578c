#include "nodes/door_planner_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ros/filter_conversions.h"
#include "ros/grid_conversions.h"
#include "ros/map_conversions.h"
#include "ros/node_main.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 10000;
constexpr bool kLatched = true;
constexpr std::uint32_t kRequestThreads = 2;
constexpr std::size_t kMatricesAtOnce = 200;  ///< then queries see what there is
constexpr std::size_t kDistrictsAtOnce = 4;   ///< between looks for news
constexpr std::size_t kMostLevelSets = 64;
constexpr double kDoorsEvery_s = 1.0;
constexpr double kMoved_m = 0.01;  ///< by which a plan must move to be sent again

}  // namespace

DoorPlannerNode::DoorPlannerNode(const core::DoorPlannerConfig& config,
                                 const core::VehicleConfig& vehicle)
    : config_(config),
      map_frame_(vehicle.map_frame),
      planner_(config),
      request_spinner_(kRequestThreads, &request_queue_) {
  request_handle_.setCallbackQueue(&request_queue_);
  plan_publisher_ = handle_.advertise<nav_msgs::Path>("plan", 2, kLatched);
  doors_publisher_ = handle_.advertise<visualization_msgs::MarkerArray>("doors", 1, kLatched);
  const auto listen = [&](ros::NodeHandle& handle, const char* topic, std::uint32_t queue,
                          auto callback) {
    subscribers_.push_back(traffic_.subscribe(handle, topic, queue, callback, this));
  };
  listen(handle_, "landmarks", 2, &DoorPlannerNode::takeMap);
  listen(handle_, "landmark_updates", kQueue, &DoorPlannerNode::takeUpdate);
  listen(handle_, "ltrs", 2, &DoorPlannerNode::takeLtrs);
  listen(handle_, "ltr_grids", kQueue, &DoorPlannerNode::takeGrid);
  listen(handle_, "pose", 10, &DoorPlannerNode::takePose);
  listen(handle_, "cekf/pose", kQueue, &DoorPlannerNode::takeFilterPose);
  listen(handle_, "level_sets", 16, &DoorPlannerNode::takeLevelSet);
  listen(request_handle_, "move_base_simple/goal", 2, &DoorPlannerNode::takeGoal);
  services_ = {request_handle_.advertiseService("plan_path", &DoorPlannerNode::planPath, this),
               request_handle_.advertiseService("make_plan", &DoorPlannerNode::makePlan, this)};
  action_ = std::make_unique<PlanServer>(
      request_handle_, "plan_path",
      [this](const PlanPathGoal& goal) { return executeAction(goal); });
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("door planner", this, &DoorPlannerNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  worker_ = std::thread(&DoorPlannerNode::work, this);
  request_spinner_.start();
}

DoorPlannerNode::~DoorPlannerNode() {
  request_spinner_.stop();
  action_->shutdown();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  worker_.join();
}

std_msgs::Header DoorPlannerNode::header() const {
  std_msgs::Header made;
  made.stamp = ros::Time::now();
  made.frame_id = map_frame_;
  return made;
}

bool DoorPlannerNode::isOurFrame(const std::string& frame, const std::string& topic) {
  if (frame == map_frame_) return true;
  causes_.count(topic + " in another frame", topic + " comes in the frame '" + frame + "', not '" +
                                                 map_frame_ + "'; it is not used.");
  return false;
}

void DoorPlannerNode::takeMap(const LandmarkMap& message) {
  if (!isOurFrame(message.header.frame_id, "landmarks")) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  mirror_.take(fromMessage(message));
  listenForRestart();
  follow(mirror_.map());
}

void DoorPlannerNode::takeUpdate(const LandmarkUpdate& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_whole = mirror_.take(fromMessage(message));
  listenForRestart();
  if (is_whole) follow(mirror_.map());
}

/// The filter's own: it tells of maps that the same filter begins anew or loads, too.
void DoorPlannerNode::takeFilterPose(const FilterPose& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mirror_.hear(message.map_version);
  if (filter_.take(countersOf(message)) == core::FilterCourse::kNewMap) beginMap();
  listenForRestart();
}

void DoorPlannerNode::listenForRestart() {
  if (mirror_.restarts() == filter_restarts_) return;
  filter_restarts_ = mirror_.restarts();
  beginMap();
  follow(mirror_.map());
}

/// The plan ends with its map: else it would be moved along with other landmarks of the same ids.
void DoorPlannerNode::beginMap() {
  ++maps_begun_;
  if (!live_) return;
  live_.reset();
  ROS_WARN("The map begins anew; the plan in the one before is given up.");
  plan_publisher_.publish(pathMessage({}, header(), {}));
}

std::size_t DoorPlannerNode::mapsBegun() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return maps_begun_;
}

/// The plan moves along at once; doors and matrices follow when the worker comes to it.
void DoorPlannerNode::follow(const core::LandmarkMap& map) {
  feed_.setLandmarks(map.landmarks);
  has_news_ = true;
  changed_.notify_all();
  if (live_) publishLive(*live_);
}

void DoorPlannerNode::publishLive(LivePlan& live) {
  const auto places =
      core::placeOf(live.plan.points, [this](int id) { return feed_.findLandmark(id); });
  if (!places) return;
  double moved_m = live.sent.size() == places->size() ? 0.0 : 2.0 * kMoved_m;
  for (std::size_t i = 0; i < places->size() && i < live.sent.size(); ++i) {
    moved_m = std::max(moved_m, ((*places)[i] - live.sent[i]).norm());
  }
  if (moved_m < kMoved_m) return;
  live.sent = *places;
  plan_publisher_.publish(pathMessage(*places, header(), live.plan.points));
}

void DoorPlannerNode::takeLtrs(const LtrMap& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  feed_.setTopology(fromMessage(message));
  has_news_ = true;
  changed_.notify_all();
}

void DoorPlannerNode::takeGrid(const LtrGrid& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!feed_.setLayer(message.ltr, message.layer, message.model, static_cast<int>(message.channels),
                      message.cells)) {
    causes_.count("layers refused", "Layer '" + message.layer + "' of an LTR has the model '" +
                                        message.model +
                                        "', which is not known here or does not fit its numbers.");
    return;
  }
  has_news_ = true;
  changed_.notify_all();
}

void DoorPlannerNode::takePose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const core::Pose2 pose = fromMessage(message.pose.pose);
  if (!isOurFrame(message.header.frame_id, "pose") || !pose.vector().allFinite()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  vehicle_ = pose;
}

void DoorPlannerNode::takeLevelSet(const LevelSet& message) {
  if (!isOurFrame(message.header.frame_id, "level_sets")) return;
  if (!std::isfinite(message.value)) {
    causes_.count("level sets refused", "A level set of a value that is not finite is refused.");
    return;
  }
  auto set = std::make_shared<const InformedPlaces>(message);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (level_sets_.size() >= kMostLevelSets && level_sets_.count(message.value) == 0) {
    causes_.count("level sets refused", "There are level sets of " +
                                            std::to_string(kMostLevelSets) +
                                            " values already; those of others are not used.");
    return;
  }
  level_sets_[message.value] = std::move(set);
}

void DoorPlannerNode::work() {
  try {
    workOn();
  } catch (const std::exception& error) {
    endAfterFailure(std::string("Paths cannot be planned any more: ") + error.what());
  }
}

void DoorPlannerNode::workOn() {
  while (true) {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return has_news_ || stopping_; });
      if (stopping_) return;
      has_news_ = false;
      feed_.tell(planner_);
      tellUnusable();
      if (vehicle_) place = vehicle_->position();
    }
    const double begin_s = steadyNow();
    for (std::size_t left = 1; left > 0;) {
      left = planner_.prepare(place, kMatricesAtOnce);
      const std::lock_guard<std::mutex> lock(mutex_);
      if (stopping_) return;
    }
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      preparation_ms_ = 1e3 * (steadyNow() - begin_s);
      counts_ = planner_.counts();
    }
    replanIfBlocked();
    publishDoors();
    prepareDistricts();
  }
}

/// The first LTR with each problem; all are counted.
void DoorPlannerNode::tellUnusable() {
  for (const auto& [id, problem] : feed_.unusable()) {
    if (!told_problems_.insert(problem).second) continue;
    ROS_WARN_STREAM("No path goes through LTR "
                    << id << ", which " << core::wordsFor(problem)
                    << ". More of them are counted in /diagnostics, not told.");
  }
}

/// Until the map changes again.
void DoorPlannerNode::prepareDistricts() {
  while (planner_.prepareDistricts(kDistrictsAtOnce) > 0) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stopping_ || has_news_) return;
  }
}

void DoorPlannerNode::replanIfBlocked() {
  Wish wish;
  std::size_t maps_begun = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!live_ || !planner_.findBlocked(live_->sent)) return;
    wish = live_->wish;
    ++blocked_plans_;
    if (vehicle_) wish.start.reset();
    maps_begun = maps_begun_;
  }
  ROS_INFO("The plan is blocked where the map has changed: planning anew.");
  keep(wish, plan(wish), maps_begun);
}

void DoorPlannerNode::publishDoors() {
  const double now_s = steadyNow();
  if (now_s - doors_sent_s_ < kDoorsEvery_s) return;
  doors_sent_s_ = now_s;
  doors_publisher_.publish(doorMarkers(*planner_.graph(), header()));
}

void DoorPlannerNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::shared_ptr<const core::DoorGraph> graph = planner_.graph();
  const std::lock_guard<std::mutex> lock(mutex_);
  status.summary(DiagnosticStatus::OK, "Ready for requests");
  if (graph->ltrs().empty()) {
    status.summary(DiagnosticStatus::WARN, "No local triangular region can be used yet");
  }
  status.add("LTRs", graph->ltrs().size());
  status.add("LTRs whose landmarks have not come", feed_.waiting());
  for (const auto& [words, count] : core::countsOf(feed_.unusable())) {
    status.add("LTRs left out: each " + words, count);
  }
  if (const std::size_t unusable = feed_.unusable().size(); unusable > 0) {
    status.mergeSummary(DiagnosticStatus::WARN,
                        std::to_string(unusable) + " LTRs are left out of plans");
  }
  status.add("portals", graph->portalCount());
  status.add("cost matrices computed", counts_.matrices);
  status.add("layers taken", counts_.contents);
  status.add("layers without a change that counts", counts_.unchanged_contents);
  status.add("layers of another grid refused", feed_.refusedContents());
  status.add("landmarks", mirror_.map().landmarks.size());
  status.add("landmark version", mirror_.map().version);
  status.add("level sets", level_sets_.size());
  status.add("last preparation [ms]", preparation_ms_);
  status.add("answering a request, last [ms]", answer_ms_);
  status.add("answering a request, worst [ms]", worst_answer_ms_);
  status.add("plans found blocked", blocked_plans_);
  for (const auto& [name, count] : answers_) status.add("requests answered " + name, count);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
}

}  // namespace hymm
