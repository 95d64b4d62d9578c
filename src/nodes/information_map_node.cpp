#include "nodes/information_map_node.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>
#include <utility>

#include "ros/information_conversions.h"
#include "ros/map_conversions.h"
#include "ros/node_main.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::size_t kMostPoses = 10000;

/// Where the last update took longer, the sets are published moved before they are computed.
constexpr double kSlowUpdate_ms = 200.0;

/// A filter that maps tells all landmarks once a second; of maps that are older than this, later
/// ones are missing.
constexpr double kMapsStopped_s = 10.0;

constexpr const char* kNoDenseMap =
    "No dense map has come on `map`: the ways know nothing of obstacles. Does hymm_grid run?";

std::string versionProblem(std::uint64_t wanted, std::uint64_t held) {
  if (wanted <= held) return {};
  return "Map version " + std::to_string(wanted) + " has not arrived; the newest is " +
         std::to_string(held) + ". Ask again, or with map_version 0 for whichever is there.";
}

}  // namespace

InformationMapNode::InformationMapNode(const core::InformationMapConfig& config,
                                       const core::VehicleConfig& vehicle)
    : map_frame_(vehicle.map_frame),
      dense_map_(map_frame_, causes_),
      information_(config, vehicle) {
  level_sets_ = handle_.advertise<LevelSet>(
      "level_sets", 16,
      [this](const ros::SingleSubscriberPublisher& subscriber) { greet(subscriber); });
  islands_markers_ = handle_.advertise<visualization_msgs::MarkerArray>("islands", 1, true);
  maps_ = traffic_.subscribe<LandmarkMap>(
      handle_, "landmarks", 2, [this](const LandmarkMapConstPtr& message) { takeMap(message); });
  poses_ = traffic_.subscribe<FilterPose>(
      handle_, "cekf/pose", 10, [this](const FilterPoseConstPtr& message) { takePose(message); });
  traffic_.expect(handle_.resolveName("cekf/pose"));
  dense_map_.subscribe(handle_, traffic_);
  ros::NodeHandle calls(handle_);
  calls.setCallbackQueue(&calls_);
  evaluate_service_ =
      calls.advertiseService("evaluate_information", &InformationMapNode::evaluate, this);
  suggest_service_ =
      calls.advertiseService("suggest_exploration", &InformationMapNode::suggest, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("level sets", this, &InformationMapNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  worker_ = std::thread(&InformationMapNode::work, this);
  call_spinner_.start();
}

InformationMapNode::~InformationMapNode() {
  call_spinner_.stop();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  worker_.join();
}

void InformationMapNode::takePose(const FilterPoseConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  pose_ = *message;
}

void InformationMapNode::takeMap(const LandmarkMapConstPtr& message) {
  if (message->header.frame_id != map_frame_) {
    causes_.count("landmarks in another frame", "Landmarks come in the frame '" +
                                                    message->header.frame_id + "', not '" +
                                                    map_frame_ + "'; they are not used.");
    return;
  }
  Waiting next;
  next.taken_s = steadyNow();
  next.map = fromMessage(*message);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (pose_) next.T_map_base = fromMessage(pose_->pose.pose);
  next.begins_anew = filter_.take({next.map.version}) == core::FilterCourse::kNewFilter ||
                     (waiting_ && waiting_->begins_anew);
  if (waiting_) ++skipped_maps_;
  waiting_ = std::move(next);
  changed_.notify_all();
}

void InformationMapNode::work() {
  try {
    while (true) {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return waiting_ || stopping_; });
      if (stopping_) return;
      const Waiting next = std::move(*waiting_);
      waiting_.reset();
      lock.unlock();
      compute(next);
    }
  } catch (const std::exception& error) {
    endAfterFailure(std::string("The level sets cannot be kept: ") + error.what());
  }
}

void InformationMapNode::compute(const Waiting& next) {
  const std::lock_guard<std::mutex> engine_lock(engine_mutex_);
  if (next.begins_anew) {
    ROS_WARN("cekf_slam was started anew; so are the level sets.");
    information_.reset();
    dense_map_.tellAgain();
  } else if (last_ms_ > kSlowUpdate_ms) {
    publish(information_.levelSetsMovedTo(next.map), false);
    const std::lock_guard<std::mutex> lock(mutex_);
    ++moved_sets_;
  }
  const double start_s = steadyNow();
  if (information_.config().dense_map.occlusion) takeDenseMap();
  const core::LevelSetUpdate update = information_.apply(next.map, next.T_map_base);
  note(update, 1e3 * (steadyNow() - start_s));
  if (update.refused.empty()) {
    publish(information_.levelSets(), update.is_complete);
    const std::lock_guard<std::mutex> lock(mutex_);
    delays_.add(1e3 * (steadyNow() - next.taken_s));
  } else {
    causes_.count("landmark map refused", update.refused);
  }
}

/// Hands the newest dense map to the engine, which is locked.
void InformationMapNode::takeDenseMap() {
  const std::optional<core::OccupancyImage> image = dense_map_.takeChanged();
  if (image) information_.setDenseMap(*image);
}

void InformationMapNode::note(const core::LevelSetUpdate& update, double ms) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_ms_ = ms;
  worst_ms_ = std::max(worst_ms_, ms);
  last_update_ = update;
  counts_ = information_.counts();
}

void InformationMapNode::publish(const core::LevelSets& sets, bool complete) {
  std::vector<LevelSet> messages;
  for (const core::LevelSet& set : sets.sets) {
    messages.push_back(toMessage(sets, set, complete, map_frame_));
    level_sets_.publish(messages.back());
  }
  if (sets.map_version == sets.computed_version) {
    islands_markers_.publish(islandMarkers(sets, map_frame_));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  published_ = std::move(messages);
}

std::string InformationMapNode::delaysText() const {
  std::ostringstream text;
  text << std::setprecision(3) << "behind their map " << delays_.quantile(0.5) << " ms (median), "
       << delays_.quantile(0.99) << " ms (99 %), " << delays_.max() << " ms (most)";
  return text.str();
}

/// Sends the sets of all values to a new subscriber; a latched topic would send the last only.
void InformationMapNode::greet(const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const LevelSet& message : published_) subscriber.publish(message);
}

bool InformationMapNode::evaluate(EvaluateInformation::Request& request,
                                  EvaluateInformation::Response& response) {
  const std::lock_guard<std::mutex> engine_lock(engine_mutex_);
  response.map_version = information_.mapVersion();
  response.message = versionProblem(request.map_version, response.map_version);
  if (request.poses.size() > kMostPoses) {
    response.message = "Asked for " + std::to_string(request.poses.size()) + " poses; at most " +
                       std::to_string(kMostPoses) + " are answered at once.";
  }
  for (const geometry_msgs::Pose2D& pose : request.poses) {
    if (std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.theta)) continue;
    response.message = "A pose has a number that is not finite.";
  }
  response.success = response.message.empty();
  if (!response.success) return true;
  for (const geometry_msgs::Pose2D& pose : request.poses) {
    const core::AchievableInformation information =
        information_.evaluate({pose.x, pose.y, core::wrapAngle(pose.theta)});
    response.information.push_back(information.value);
    response.landmarks.push_back(information.landmarks);
    for (int i = 0; i < 9; ++i) response.matrices.push_back(information.matrix(i / 3, i % 3));
  }
  return true;
}

bool InformationMapNode::suggest(SuggestExploration::Request& request,
                                 SuggestExploration::Response& response) {
  core::ExplorationRequest exploration;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!pose_) {
      response.message = "No pose of the vehicle has come on cekf/pose yet.";
      return true;
    }
    exploration.T_map_base = fromMessage(pose_->pose.pose);
    exploration.covariance = planarCovariance(pose_->pose);
  }
  const std::lock_guard<std::mutex> engine_lock(engine_mutex_);
  takeDenseMap();
  exploration.level = request.value > 0.0 ? information_.levelOf(request.value) : 1;
  const core::ExplorationAnswer answer = information_.suggestExploration(exploration);
  response.map_version = information_.mapVersion();
  response.message = answer.problem;
  response.success = answer.problem.empty();
  if (response.success && !information_.hasDenseMap()) {
    response.message = kNoDenseMap;
  }
  for (const core::ExplorationGoal& goal : answer.goals) response.goals.push_back(toMessage(goal));
  return true;
}

/// By stamps, so that it holds in a playback at any speed. Called with mutex_ held.
std::optional<double> InformationMapNode::mapAge_s() const {
  if (!pose_ || published_.empty()) return std::nullopt;
  // In seconds, for a difference of stamps far apart would throw.
  return pose_->header.stamp.toSec() - published_.front().header.stamp.toSec();
}

/// Called with mutex_ held.
void InformationMapNode::summarize(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "Level sets are kept");
  if (counts_.maps == 0) {
    status.mergeSummary(DiagnosticStatus::WARN, "No landmark map has been used");
  }
  if (!last_update_.refused.empty()) {
    status.mergeSummary(DiagnosticStatus::ERROR, last_update_.refused);
  } else if (!last_update_.is_complete) {
    status.mergeSummary(DiagnosticStatus::WARN,
                        "level_sets.max_evaluations leaves level sets unfinished");
  }
  if (const std::optional<double> age_s = mapAge_s()) {
    status.add("age of the landmark map at the last pose [s]", *age_s);
    if (*age_s > kMapsStopped_s) {
      status.mergeSummary(DiagnosticStatus::WARN,
                          "No landmark map has come for " + std::to_string(std::lround(*age_s)) +
                              " s, though poses do; the level sets are those of the last one");
    }
  }
}

void InformationMapNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  summarize(status);
  status.add("dense map",
             dense_map_.hasMap() ? "there" : "none yet: ways know nothing of obstacles");
  status.add("maps used", counts_.maps);
  status.add("maps refused", counts_.refused_maps);
  status.add("maps passed over for a newer one", skipped_maps_);
  status.add("sets moved along before they were computed", moved_sets_);
  status.add("landmarks refused", counts_.refused_landmarks);
  status.add("updates ended by max_evaluations", counts_.unfinished_updates);
  status.add("evaluations, all", counts_.evaluations);
  status.add("evaluations, last map", last_update_.evaluations);
  status.add("sets", delaysText());
  status.add("update, last [ms]", last_ms_);
  status.add("update, worst of the last second [ms]", worst_ms_);
  for (std::size_t i = 0; i < published_.size(); ++i) {
    const LevelSet& set = published_[i];
    const std::string name = "value " + std::to_string(set.value) + ": ";
    status.add(name + "area [m^2]", set.area);
    status.add(name + "islands", set.islands.size());
    if (i >= last_update_.levels.size()) continue;
    status.add(name + "area lost, last map [m^2]", last_update_.levels[i].lost_m2);
    status.add(name + "area gained, last map [m^2]", last_update_.levels[i].gained_m2);
  }
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
  worst_ms_ = 0.0;
}

}  // namespace hymm
