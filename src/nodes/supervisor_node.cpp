#include "nodes/supervisor_node.h"

#include <algorithm>
#include <array>
#include <limits>

#include <hymm/FilterStatus.h>
#include <hymm/Resume.h>

#include "ros/filter_conversions.h"
#include "ros/map_conversions.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kQueue = 10000;
constexpr bool kLatched = true;
constexpr double kLandmarkWait_s = 0.2;  // by the wall, for the landmarks of a pose

}  // namespace

SupervisorNode::SupervisorNode(const core::SupervisorConfig& config,
                               const core::CekfSlamConfig& filter,
                               const core::VehicleConfig& vehicle)
    : config_(config),
      of_detections_(filter.observation_input == "detections"),
      old_landmarks_(config.old_landmarks),
      first_order_(ros::WallTime::now().toNSec() / 1000U),
      orders_(first_order_),
      transforms_(tf_, causes_),
      relocaliser_(handle_, [this] { processAnswers(); }),
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
  subscribe();
  set_mode_service_ = handle_.advertiseService("set_mode", &SupervisorNode::setMode, this);
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("supervisor", this, &SupervisorNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  timer_ = handle_.createSteadyTimer(ros::WallDuration(1.0 / config.tf_rate_hz),
                                     [this](const ros::SteadyTimerEvent&) { tick(); });
  decide(ros::Time::now());
}

void SupervisorNode::subscribe() {
  const auto hints = ros::TransportHints().tcpNoDelay();
  const auto listen = [&](const char* topic, auto callback) {
    subscribers_.push_back(traffic_.subscribe(handle_, topic, kQueue, callback, this, hints));
  };
  listen("cekf/pose", &SupervisorNode::takePose);
  listen("cekf/health", &SupervisorNode::takeHealth);
  listen("landmarks", &SupervisorNode::takeMap);
  listen("landmark_updates", &SupervisorNode::takeUpdate);
  listen("grid_status", &SupervisorNode::takeGridStatus);
  listen("odom", &SupervisorNode::takeOdometry);
  listen("gps/fix", &SupervisorNode::takeGps);
  traffic_.expect(handle_.resolveName("cekf/pose"));
  traffic_.expect(handle_.resolveName("cekf/health"));
}

void SupervisorNode::takePose(const FilterPose& message) {
  pairing_.add(message);
  pairAnswers();
}

void SupervisorNode::takeHealth(const FilterHealth& message) {
  pairing_.add(message);
  pairAnswers();
}

void SupervisorNode::takeMap(const LandmarkMap& message) {
  landmarks_.take(fromMessage(message));
  processAnswers();
}

void SupervisorNode::takeUpdate(const LandmarkUpdate& message) {
  landmarks_.take(fromMessage(message));  // what is missing comes with the next whole map
  processAnswers();
}

void SupervisorNode::takeGridStatus(const GridStatus& message) {
  agreement_.take(message.header.stamp.toSec(), message.agreement);
}

void SupervisorNode::pairAnswers() {
  while (const std::optional<FilterAnswer> answer = pairing_.next()) {
    answers_.push_back({*answer, steadyNow()});
  }
  processAnswers();
}

void SupervisorNode::processAnswers() {
  while (!answers_.empty() && isComplete(answers_.front().answer, answers_.front().since_s)) {
    const Waiting next = answers_.front();
    answers_.pop_front();
    process(next.answer);
    worst_latency_ms_ = std::max(worst_latency_ms_, 1e3 * (steadyNow() - next.since_s));
  }
}

/// Whether all that the decision on a scan rests on has come, or will not come.
bool SupervisorNode::isComplete(const FilterAnswer& answer, double since_s) const {
  const double now_s = steadyNow();
  const bool has_landmarks = landmarks_.map().version >= answer.pose.map_version;
  if (!has_landmarks && now_s - since_s < kLandmarkWait_s) return false;
  if (decision_.mode != core::FilterMode::kRelocalising || endsSearch(answer)) return true;
  // One that was started anew, or forgot its search, will not answer; what it says is told apart.
  if (!relocaliser_.knows(orders_) && now_s - since_s > config_.pose_timeout_s) return true;
  if (relocaliser_.hasAnswered(orders_, answer.pose.header.stamp)) return true;
  const auto relocaliser = relocaliser_.evidence(orders_, now_s);
  return !relocaliser || relocaliser->age_s > config_.pose_timeout_s;
}

/// Whether the scan is of another recording, of another map or of a filter started anew: the
/// relocaliser ends its search then, and answers no more.
bool SupervisorNode::endsSearch(const FilterAnswer& answer) const {
  return answer.pose.header.stamp < pose_stamp_ ||
         filter_.courseOf(answer.counters()) != core::FilterCourse::kGoesOn;
}

void SupervisorNode::process(const FilterAnswer& answer) {
  const std_msgs::Header& header = answer.pose.header;
  const core::FilterCourse course = filter_.take(answer.counters());
  landmarks_.hear(answer.pose.map_version);
  if (course == core::FilterCourse::kNewFilter) noteRestart();
  if (header.stamp < pose_stamp_) {
    beginRecording();
  } else if (course != core::FilterCourse::kGoesOn) {
    beginMap();
  }
  filter_landmarks_ = answer.health.landmarks;
  pose_stamp_ = header.stamp;
  pose_wall_s_ = steadyNow();
  ++poses_;
  publishPose(answer);
  evidence_ = core::evidenceAtScan(fromMessage(answer.health));
  const core::PoseEstimate pose = fromMessage(answer.pose);
  evidence_.of_detections = of_detections_;
  evidence_.waits = answer.pose.suspended != 0U;
  evidence_.scan.disagreement = agreement_.disagreementAt(pose.time_s);
  const core::OldLandmarksInView old = old_landmarks_.look(
      landmarks_.map().landmarks, pose.T_map_base * pose.T_base_sensor, pose.time_s);
  evidence_.scan.old_landmarks_expected = old.expected;
  evidence_.scan.unseen = old.unseenShare();
  decide(header.stamp);
}

/// The pose of the filter that is in charge of the scan.
void SupervisorNode::publishPose(const FilterAnswer& answer) {
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header = answer.pose.header;
  pose.pose = answer.pose.pose;
  if (decision_.mode == core::FilterMode::kRelocalising) {
    if (const auto found = relocaliser_.poseAt(pose.header.stamp)) pose.pose = *found;
  }
  pose_publisher_.publish(pose);
  const core::Pose2 T_map_base = fromMessage(pose.pose.pose);
  trajectory_.add(pose.header.stamp, T_map_base);
  gps_.addPose(pose.header.stamp.toSec(), T_map_base);
  map_odom_.setPose(pose.header.stamp, T_map_base, *pose_wall_s_);
}

/// A filter that was killed and started anew has lost its map; nobody else can tell.
void SupervisorNode::noteRestart() {
  lost_ = "cekf_slam was started anew: its map of " + std::to_string(filter_landmarks_) +
          " landmarks is lost, and a new one begins where the vehicle was. ";
  ROS_ERROR_STREAM(lost_);
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

bool SupervisorNode::setMode(SetMode::Request& request, SetMode::Response& response) {
  const std::array<core::FilterMode, 2> modes = {core::FilterMode::kCekf,
                                                 core::FilterMode::kRelocalising};
  const auto* asked = std::find_if(modes.begin(), modes.end(), [&](core::FilterMode mode) {
    return core::nameOf(mode) == request.mode;
  });
  if (asked == modes.end()) {
    response.message =
        "There is no mode '" + request.mode + "' to be asked for; it is CEKF or RELOCALISING.";
    return true;
  }
  evidence_.requested = *asked;
  decide(ros::Time::now());
  response.success = static_cast<std::uint8_t>(decision_.mode == *asked);
  response.message = decision_.reason;
  if (response.success == 0U) {
    response.message = "Nothing changes: no filter has given a pose yet, or no relocaliser runs. " +
                       response.message;
  }
  return true;
}

void SupervisorNode::tick() {
  const double now_s = steadyNow();
  processAnswers();
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
  const double now_s = steadyNow();
  if (pose_wall_s_) evidence_.pose_age_s = now_s - *pose_wall_s_;
  evidence_.odometry_problem = map_odom_.problem();
  evidence_.odometry_known = evidence_.odometry_problem.empty();
  evidence_.relocaliser = relocaliser_.evidence(orders_, now_s);
  if (relocaliser_.takeWish()) evidence_.requested = core::FilterMode::kRelocalising;
  const core::SupervisorDecision next = core::computeDecision(decision_.state, evidence_, config_);
  evidence_.new_scan = false;
  evidence_.requested.reset();
  const bool tell = !status_sent_ || next.mode != decision_.mode ||
                    next.silent != decision_.silent ||
                    next.without_odometry != decision_.without_odometry || !lost_.empty() ||
                    next.action != core::SupervisorAction::kNothing;
  if (core::isModeSwitch(decision_.mode, next.mode)) {
    ++mode_switches_;
    ROS_WARN_STREAM(core::nameOf(next.mode) << ": " << next.reason);
  }
  decision_ = next;
  decision_.reason = lost_ + decision_.reason;
  lost_.clear();
  act();
  if (tell) publishStatus(decision_, stamp);
}

/// What the relocaliser has to do, `filter_status` tells it.
void SupervisorNode::act() {
  if (decision_.action == core::SupervisorAction::kBeginRelocalising) ++orders_;
  const bool ends_waiting = decision_.action == core::SupervisorAction::kEndWaiting;
  if (!ends_waiting && decision_.action != core::SupervisorAction::kResumeWithoutClosing) return;
  Resume service;
  service.request.way = Resume::Request::WITHOUT_CLOSING;
  if (!ends_waiting) service.request.since = toRosTime(decision_.from_s);
  calls_.run([name = handle_.resolveName("resume"), service]() mutable {
    if (!ros::service::call(name, service)) {
      ROS_ERROR_STREAM("The service '" << name << "' does not answer; does cekf_slam run?");
    } else if (service.response.success == 0U) {
      ROS_ERROR_STREAM("The CEKF goes on from where it is: " << service.response.message);
    }
  });
}

void SupervisorNode::publishStatus(const core::SupervisorDecision& decision,
                                   const ros::Time& stamp) {
  FilterStatus message;
  message.header.stamp = stamp;
  message.mode = core::nameOf(decision.mode);
  message.reason = decision.reason;
  message.in_good_order = toRosTime(decision.from_s);
  message.order = orders_;
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
  agreement_.clear();
  landmarks_ = core::LandmarkMirror();
  beginMap();
}

/// What was doubted of the map before, and searched for in it, ends with it.
void SupervisorNode::beginMap() {
  decision_.state = {};
  old_landmarks_.clear();
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
  status.add("latency from a pose to its decision, worst of the last second [ms]",
             worst_latency_ms_);
  status.add("poses not decided on yet", answers_.size());
  status.add("poses or healths without the other", pairing_.unpaired());
  status.add("landmarks", landmarks_.map().landmarks.size());
  status.add("landmark version", landmarks_.map().version);
  status.add("poses of the trajectory", trajectory_.message().poses.size());
  status.add("mode switches", mode_switches_);
  status.add("orders to the relocaliser", orders_ - first_order_);
  for (const core::EvidenceFigure& figure : decision_.figures)
    status.add(figure.name, figure.value);
  if (poses_ > 0 && ros::Time::now().isZero()) {  // a playback before has left the parameter
    causes_.count("times at which no clock ran",
                  "use_sim_time is true, but nobody publishes /clock: times that nodes take from "
                  "it are 0. On a robot, `rosparam set use_sim_time false` and launch anew.");
    status.mergeSummary(DiagnosticStatus::ERROR, "use_sim_time is true, but there is no /clock");
  }
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
  for (const auto& [node, count] : watch_.others()) {
    status.add("map -> odom from " + node, count);
    status.mergeSummary(DiagnosticStatus::ERROR, node + " publishes map -> odom, too");
  }
  worst_latency_ms_ = 0.0;
}

}  // namespace hymm
