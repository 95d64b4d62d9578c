#include "nodes/supervisor_node.h"

#include <limits>

#include <hymm/FilterStatus.h>

#include "ros/filter_conversions.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 10000;
constexpr bool kLatched = true;

}  // namespace

SupervisorNode::SupervisorNode(const core::SupervisorConfig& config,
                               const core::VehicleConfig& vehicle)
    : config_(config),
      tf_listener_(tf_),
      map_odom_(tf_, vehicle, config.transform_wait_s),
      watch_(handle_, vehicle.odom_frame),
      trajectory_(vehicle.map_frame, config.trajectory_spacing_m,
                  static_cast<std::size_t>(config.trajectory_max_poses)),
      dead_reckoning_(vehicle.map_frame, config.trajectory_spacing_m,
                      static_cast<std::size_t>(config.trajectory_max_poses)),
      gps_(vehicle.gps_antenna.T_base_sensor().position(), vehicle.map_frame) {
  pose_publisher_ = handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", kQueue);
  status_publisher_ = handle_.advertise<FilterStatus>("filter_status", 100, kLatched);
  trajectory_publisher_ = handle_.advertise<nav_msgs::Path>("trajectory", 2, kLatched);
  dead_reckoning_publisher_ = handle_.advertise<nav_msgs::Path>("dead_reckoning_path", 2, kLatched);
  gps_publisher_ = handle_.advertise<visualization_msgs::Marker>("gps_markers", 2, kLatched);
  const auto hints = ros::TransportHints().tcpNoDelay();
  pose_subscriber_ = handle_.subscribe("cekf/pose", kQueue, &SupervisorNode::takePose, this, hints);
  health_subscriber_ =
      handle_.subscribe("cekf/health", kQueue, &SupervisorNode::takeHealth, this, hints);
  odometry_subscriber_ =
      handle_.subscribe("odom", kQueue, &SupervisorNode::takeOdometry, this, hints);
  gps_subscriber_ = handle_.subscribe("gps/fix", kQueue, &SupervisorNode::takeGps, this, hints);
  initial_pose_subscriber_ =
      handle_.subscribe("initialpose", 10, &SupervisorNode::takeInitialPose, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("supervisor", this, &SupervisorNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  timer_ = handle_.createSteadyTimer(ros::WallDuration(1.0 / config.tf_rate_hz),
                                     [this](const ros::SteadyTimerEvent&) { tick(); });
  decide(ros::Time::now());
}

void SupervisorNode::takePose(const FilterPose& message) {
  pairing_.add(message);
  processPairs();
}

void SupervisorNode::takeHealth(const FilterHealth& message) {
  pairing_.add(message);
  processPairs();
}

void SupervisorNode::processPairs() {
  while (const std::optional<FilterAnswer> answer = pairing_.next()) process(*answer);
}

void SupervisorNode::process(const FilterAnswer& answer) {
  const std_msgs::Header& header = answer.pose.header;
  if (header.stamp < pose_stamp_) {
    beginRecording();
  } else if (resets_ && answer.health.resets != *resets_) {
    beginMap();
  }
  resets_ = answer.health.resets;
  pose_stamp_ = header.stamp;
  pose_wall_s_ = steadyNow();
  ++poses_;
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header = header;
  pose.pose = answer.pose.pose;
  pose_publisher_.publish(pose);
  const core::Pose2 T_map_base = fromMessage(answer.pose.pose.pose);
  trajectory_.add(header.stamp, T_map_base);
  gps_.addPose(header.stamp.toSec(), T_map_base);
  map_odom_.setPose(header.stamp, T_map_base, *pose_wall_s_);
  evidence_ = core::evidenceAtScan(fromMessage(answer.health));
  decide(header.stamp);
}

void SupervisorNode::takeOdometry(const nav_msgs::Odometry& message) {
  const core::Pose2 T_odom_base = fromMessage(message.pose.pose);
  if (!T_odom_base.vector().allFinite()) {
    causes_.count("odom refused",
                  "An odom message has a pose that is not finite; it is not drawn.");
    return;
  }
  if (!T_odom_first_) T_odom_first_ = T_odom_base;
  dead_reckoning_.add(message.header.stamp, core::inverse(*T_odom_first_) * T_odom_base);
}

void SupervisorNode::takeGps(const sensor_msgs::NavSatFix& message) { gps_.addFix(message); }

void SupervisorNode::takeInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  ++initial_poses_refused_;
  core::SupervisorDecision told = decision_;
  told.reason = "An initialpose in frame '" + message.header.frame_id +
                "' is not followed: placing the vehicle in a map that exists takes the "
                "relocaliser, which is not running. To begin a new map here, call 'reset'. " +
                decision_.reason;
  ROS_WARN_STREAM(told.reason);
  publishStatus(told, ros::Time::now());
}

void SupervisorNode::tick() {
  const double now_s = steadyNow();
  map_odom_.broadcast(ros::Time::now(), now_s);
  decide(ros::Time::now());
  const bool due = now_s - trajectory_sent_s_ >= 1.0 / config_.trajectory_rate_hz;
  if (!due || trajectory_.message().poses.size() == trajectory_sent_poses_) return;
  publishPaths();
  trajectory_sent_s_ = now_s;
  trajectory_sent_poses_ = trajectory_.message().poses.size();
}

void SupervisorNode::publishPaths() {
  trajectory_publisher_.publish(trajectory_.message());
  dead_reckoning_publisher_.publish(dead_reckoning_.message());
  if (gps_.count() > 0) gps_publisher_.publish(gps_.marker());
}

void SupervisorNode::decide(const ros::Time& stamp) {
  if (pose_wall_s_) evidence_.pose_age_s = steadyNow() - *pose_wall_s_;
  evidence_.odometry_problem = map_odom_.problem();
  evidence_.odometry_known = evidence_.odometry_problem.empty();
  const core::SupervisorDecision next = core::computeDecision(decision_.state, evidence_, config_);
  evidence_.new_scan = false;
  const bool tell = !status_sent_ || next.mode != decision_.mode ||
                    next.silent != decision_.silent ||
                    next.without_odometry != decision_.without_odometry;
  decision_ = next;
  if (tell) publishStatus(decision_, stamp);
}

void SupervisorNode::publishStatus(const core::SupervisorDecision& decision,
                                   const ros::Time& stamp) {
  FilterStatus message;
  message.header.stamp = stamp;
  message.mode = core::nameOf(decision.mode);
  message.reason = decision.reason;
  for (const core::EvidenceFigure& figure : decision.figures) {
    Evidence evidence;
    evidence.name = figure.name;
    evidence.value = figure.value;
    evidence.limit = figure.limit.value_or(std::numeric_limits<double>::quiet_NaN());
    message.evidence.push_back(evidence);
  }
  status_publisher_.publish(message);
  status_sent_ = true;
}

void SupervisorNode::beginRecording() {
  ROS_WARN("The poses' time stamps ran back: another recording begins.");
  tf_.clear();
  map_odom_.reset();
  decision_.state = {decision_.mode};
  beginMap();
}

void SupervisorNode::beginMap() {
  trajectory_.clear();
  dead_reckoning_.clear();
  gps_.clear();
  T_odom_first_.reset();
  trajectory_sent_poses_ = 0;
}

void SupervisorNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const bool well =
      decision_.mode == core::FilterMode::kCekf && !decision_.silent && !decision_.without_odometry;
  status.summary(well ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 core::nameOf(decision_.mode) + ": " + decision_.reason);
  status.add("poses", poses_);
  status.add("initialpose not followed", initial_poses_refused_);
  for (const core::EvidenceFigure& figure : decision_.figures)
    status.add(figure.name, figure.value);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
  for (const auto& [node, count] : watch_.others()) {
    status.add("map -> odom from " + node, count);
    status.mergeSummary(DiagnosticStatus::ERROR, node + " publishes map -> odom, too");
  }
}

}  // namespace hymm
