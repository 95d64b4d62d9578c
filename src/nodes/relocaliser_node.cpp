#include "nodes/relocaliser_node.h"

#include <chrono>

#include <Eigen/Eigenvalues>
#include <geometry_msgs/PoseArray.h>

#include "ros/filter_conversions.h"
#include "ros/map_conversions.h"
#include "ros/node_main.h"
#include "ros/pose_conversions.h"
#include "ros/relocaliser_conversions.h"
#include "ros/sensor_conversions.h"
#include "ros/steady_time.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 10000;
constexpr auto kPatience = std::chrono::milliseconds(20);
constexpr double kHeartbeat_s = 0.2;
constexpr double kMountingWait_s = 5.0;  // tf_static comes within moments, or not at all
constexpr std::size_t kMostUnpaired = 1000;
constexpr std::size_t kMostParticlesShown = 2000;

/// Drops the oldest of what waits for its partner.
template <class Map>
void bound(Map& waiting) {
  while (waiting.size() > kMostUnpaired) waiting.erase(waiting.begin());
}

bool isCovariance(const Eigen::Matrix3d& P) {
  if (!P.allFinite() || (P - P.transpose()).cwiseAbs().maxCoeff() > 1e-9 * P.trace()) return false;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(P).eigenvalues().minCoeff() > 0.0;
}

}  // namespace

RelocaliserNode::RelocaliserNode(const core::RelocaliserConfig& config,
                                 const core::CekfSlamConfig& filter,
                                 const core::VehicleConfig& vehicle)
    : map_frame_(vehicle.map_frame),
      transforms_(tf_, causes_),
      mountings_(tf_, vehicle.base_frame, std::nullopt, kMountingWait_s),
      merger_(filter.merger),
      link_(handle_, vehicle.map_frame),
      relocalisation_(config, vehicle, link_) {
  pose_publisher_ =
      handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>("relocaliser/pose", kQueue);
  health_publisher_ = handle_.advertise<RelocaliserHealth>("relocaliser/health", kQueue);
  particles_publisher_ = handle_.advertise<geometry_msgs::PoseArray>("relocaliser/particles", 2);
  subscribe(filter.motion_input);
  global_service_ =
      handle_.advertiseService("global_localization", &RelocaliserNode::localiseGlobally, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", this, &RelocaliserNode::diagnoseInputs);
  diagnostics_.add("search", this, &RelocaliserNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  publish(relocalisation_.report());
  heartbeat_ = handle_.createSteadyTimer(ros::WallDuration(kHeartbeat_s),
                                         [this](const ros::SteadyTimerEvent&) { publishHealth(); });
  worker_ = std::thread(&RelocaliserNode::work, this);
}

RelocaliserNode::~RelocaliserNode() {
  working_ = false;
  worker_.join();
}

void RelocaliserNode::subscribe(const std::string& motion_input) {
  const auto hints = ros::TransportHints().tcpNoDelay();
  const auto listen = [&](const char* topic, auto callback) {
    subscribers_.push_back(traffic_.subscribe(handle_, topic, kQueue, callback, this, hints));
  };
  if (motion_input == "odom") {
    listen("odom", &RelocaliserNode::takeOdometry);
  } else {
    listen("dead_reckoning", &RelocaliserNode::takeDeadReckoning);
  }
  for (const char* topic : {motion_input.c_str(), "landmark_observations", "cekf/pose"}) {
    traffic_.expect(handle_.resolveName(topic));
  }
  listen("landmark_observations", &RelocaliserNode::takeObservations);
  listen("cekf/pose", &RelocaliserNode::takePose);
  listen("landmarks", &RelocaliserNode::takeMap);
  listen("landmark_updates", &RelocaliserNode::takeUpdate);
  listen("filter_status", &RelocaliserNode::takeStatus);
  listen("initialpose", &RelocaliserNode::takeInitialPose);
}

void RelocaliserNode::takeDeadReckoning(const DeadReckoning& message) {
  takeMotion(fromMessage(message));
}

void RelocaliserNode::takeOdometry(const nav_msgs::Odometry& message) {
  // What comes before tf tells where the frame stands is not needed: nothing is searched yet.
  const OdometryReader::Answer answer = odometry_.read(message, mountings_, steadyNow(), causes_);
  if (answer.input) takeMotion(*answer.input);
}

void RelocaliserNode::takeMotion(const core::MotionInput& input) {
  if (!core::isFinite(input)) {
    causes_.count("motion refused", "A motion input is not finite; it is not used.");
    return;
  }
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  merger_.push(input, steadyNow());
}

void RelocaliserNode::takeObservations(const LandmarkObservations& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  sets_[message.header.stamp] = fromMessage(message);
  pairObservations();
}

void RelocaliserNode::takePose(const FilterPose& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  poses_[message.header.stamp] = message;
  pairObservations();
}

/// What the filter took of a scan and where it stood come on two topics.
void RelocaliserNode::pairObservations() {
  for (auto set = sets_.begin(); set != sets_.end();) {
    const auto pose = poses_.find(set->first);
    if (pose == poses_.end()) {
      ++set;
      continue;
    }
    set->second.T_base_sensor = fromMessage(pose->second.sensor);
    paired_poses_[set->second.time_s] = pose->second;
    merger_.push(set->second, steadyNow());
    poses_.erase(pose);
    set = sets_.erase(set);
    arrived_.notify_one();
  }
  bound(sets_);
  bound(poses_);
  bound(paired_poses_);
}

void RelocaliserNode::takeMap(const LandmarkMap& message) {
  if (message.header.frame_id != map_frame_) {
    causes_.count("landmarks in another frame", "Landmarks come in the frame '" +
                                                    message.header.frame_id + "', not '" +
                                                    map_frame_ + "'; they are not used.");
    return;
  }
  link_.take(fromMessage(message));
}

void RelocaliserNode::takeUpdate(const LandmarkUpdate& message) {
  if (!link_.take(fromMessage(message))) {
    causes_.count("map incomplete", "Changes of the map are missing; waiting for the whole map.");
  }
}

void RelocaliserNode::takeStatus(const FilterStatus& message) { order(message); }

void RelocaliserNode::takeInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const core::PosePrior place{fromMessage(message.pose.pose), planarCovariance(message.pose)};
  std::string problem;
  if (message.header.frame_id != map_frame_) {
    problem = "it is in the frame '" + message.header.frame_id + "', not '" + map_frame_ + "'";
  } else if (!place.mean.vector().allFinite()) {
    problem = "it is not finite";
  } else if (!isCovariance(place.covariance)) {
    problem = "its covariance of x, y and yaw is not symmetric and positive definite";
  } else if (!link_.hasLandmarks()) {
    problem = "there is no map yet to be placed in";
  }
  if (!problem.empty()) {
    causes_.count("initialpose refused: " + problem, "An initialpose is refused: " + problem + ".");
    return;
  }
  order(core::SearchWish{place});
}

bool RelocaliserNode::localiseGlobally(std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
  if (!link_.hasLandmarks()) {
    causes_.count("global localisation without a map",
                  "There is no map yet to be localised in; global_localization does nothing.");
    return true;
  }
  order(core::SearchWish{});
  return true;
}

void RelocaliserNode::order(Command command) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  commands_.push_back(std::move(command));
  arrived_.notify_one();
}

void RelocaliserNode::work() {
  try {
    workOn();
  } catch (const std::exception& error) {
    endAfterFailure(std::string("The relocaliser cannot go on: ") + error.what());
  }
}

void RelocaliserNode::workOn() {
  bool is_busy = false;
  while (working_) {
    std::deque<Command> commands;
    std::vector<core::SensorEvent> events;
    {
      std::unique_lock<std::mutex> lock(inputs_mutex_);
      if (commands_.empty() && !is_busy) arrived_.wait_for(lock, kPatience);
      commands.swap(commands_);
      events = merger_.popReady(steadyNow());
    }
    for (const core::SensorEvent& event : events) process(event);
    for (const Command& command : commands) obey(command);
    is_busy = search();
  }
}

/// One piece of the search, so that orders and the end are heard meanwhile.
bool RelocaliserNode::search() {
  const double start_s = steadyNow();
  const bool is_busy = relocalisation_.work();
  worked_s_ += steadyNow() - start_s;
  if (!relocalisation_.takeNews()) return is_busy;
  publish(relocalisation_.report());
  worked_s_ = 0.0;
  return is_busy;
}

void RelocaliserNode::process(const core::SensorEvent& event) {
  if (const auto* input = std::get_if<core::MotionInput>(&event)) {
    relocalisation_.take(*input);
  } else if (const auto* set = std::get_if<core::ObservationSet>(&event)) {
    processScan(*set);
  } else if (std::holds_alternative<core::ClockReset>(event)) {
    ROS_WARN("The time stamps ran back: another recording begins.");
    relocalisation_.reset();
  }
}

void RelocaliserNode::processScan(const core::ObservationSet& set) {
  FilterPose pose;
  {
    const std::lock_guard<std::mutex> lock(inputs_mutex_);
    const auto paired = paired_poses_.find(set.time_s);
    if (paired == paired_poses_.end()) return;
    pose = paired->second;
    paired_poses_.erase(paired_poses_.begin(), std::next(paired));
  }
  const core::FilterCourse course = filter_.take(countersOf(pose));
  link_.hear(pose.map_version);
  if (course != core::FilterCourse::kGoesOn) {
    ROS_WARN("The filter began a new map; what was kept of the old one is forgotten.");
    relocalisation_.reset();
  }
  if (course == core::FilterCourse::kNewMap) link_.forgetLandmarks();
  relocalisation_.take(set, fromMessage(pose));
}

void RelocaliserNode::obey(const Command& command) {
  if (const auto* wish = std::get_if<core::SearchWish>(&command)) {
    relocalisation_.wish(*wish);
    wishes_.add(ros::WallTime::now());
    publish(relocalisation_.report());  // tells of the wish
  } else {
    obey(std::get<FilterStatus>(command));
  }
}

void RelocaliserNode::obey(const FilterStatus& status) {
  if (status.mode != FilterStatus::RELOCALISING) {
    relocalisation_.end();
  } else if (status.order != last_order_) {
    last_order_ = status.order;
    relocalisation_.begin(
        {status.order, status.in_good_order.toSec(), status.header.stamp.toSec()});
    ROS_WARN_STREAM(relocalisation_.report().reason);
  }
}

void RelocaliserNode::publish(const core::SearchReport& report) {
  RelocaliserHealth health = toMessage(report, map_frame_);
  const core::Relocaliser* engine = relocalisation_.search().engine();
  if (report.pose) {
    geometry_msgs::PoseWithCovarianceStamped pose;
    pose.header = health.header;
    pose.pose = toMessage(report.pose->mean, report.pose->covariance);
    pose_publisher_.publish(pose);
  }
  if (engine != nullptr && particles_publisher_.getNumSubscribers() > 0) {
    geometry_msgs::PoseArray particles = toMessage(*engine, kMostParticlesShown);
    particles.header = health.header;
    particles_publisher_.publish(particles);
  }
  if (engine != nullptr) {
    health.landmarks = static_cast<std::uint32_t>(engine->map().landmarks.size());
    health.begun_at = toRosTime(relocalisation_.search().begun_s());
    health.rivals = engine->counts().rivals;
  }
  health.wish = wishes_.last();
  health.searches = relocalisation_.searches();
  health.latency_ms = 1e3 * worked_s_;
  {
    const std::lock_guard<std::mutex> lock(health_mutex_);
    health_ = health;
  }
  publishHealth();
}

void RelocaliserNode::publishHealth() {
  const std::lock_guard<std::mutex> lock(health_mutex_);
  health_publisher_.publish(health_);
}

void RelocaliserNode::diagnoseInputs(diagnostic_updater::DiagnosticStatusWrapper& status) {
  traffic_.diagnose(status);
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  status.add("observations that wait for their pose", sets_.size());
  status.add("poses that wait for their observations", poses_.size());
  status.add("scans that wait to be used", paired_poses_.size());
  status.add("dropped messages (out of order)", merger_.counts().out_of_order);
  status.add("scans without motion past their stamp", merger_.counts().without_motion);
  status.add("clock resets", merger_.counts().clock_resets);
}

void RelocaliserNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(health_mutex_);
  const bool well =
      health_.state == RelocaliserHealth::IDLE || health_.state == RelocaliserHealth::ACCEPTED;
  status.summary(well ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 health_.state + ": " + health_.reason);
  status.add("searches", health_.searches);
  status.add("landmarks of the map", health_.landmarks);
  status.add("particles", health_.particles);
  status.add("modes", health_.modes);
  status.add("share of the heaviest mode", health_.heaviest);
  status.add("times that another place explained the scans as well", health_.rivals);
  status.add("latency, last scan [ms]", health_.latency_ms);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
}

}  // namespace hymm
