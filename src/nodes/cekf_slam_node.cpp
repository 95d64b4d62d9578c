#include "nodes/cekf_slam_node.h"

#include <algorithm>
#include <cctype>
#include <future>
#include <memory>

#include "common/number_text.h"
#include "ros/joint_covariance.h"
#include "ros/node_main.h"
#include "ros/relocaliser_conversions.h"
#include "ros/steady_time.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

constexpr double kMountingWait_s = 5.0;        // tf_static comes within moments, or not at all
constexpr std::size_t kQueueCapacity = 20000;  // over a minute of a car's sensors at 5 times speed
constexpr double kSilence_s = 1.0;             // without scans: time to send what is held back
constexpr auto kPatience = std::chrono::milliseconds(10);

std::optional<core::Pose2> laserFallback(const core::VehicleDescription& vehicle) {
  if (!vehicle.tells_laser) return std::nullopt;
  return vehicle.config.laser.T_base_sensor();
}

/// A reason without its figures, so that the same cause counts as the same.
std::string causeOf(const std::string& reason) {
  const auto digit = std::find_if(reason.begin(), reason.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  return "scan refused: " + std::string(reason.begin(), digit);
}

/// A message's header, with the stamp of what was read of it: clouds may begin before theirs.
std_msgs::Header headerAt(double time_s, const SensorMessage& message) {
  std_msgs::Header header = headerOf(message);
  if (header.stamp.toSec() != time_s) header.stamp = toRosTime(time_s);
  return header;
}

std::string suspensionText(double from_s, bool is_suspended, const core::CekfSlam& filter) {
  const std::string scan = "the scan at " + core::numberText(from_s) + " s";
  if (is_suspended) return "The filter went back to " + scan + ", and waits there for 'resume'.";
  const std::optional<core::LocalStateSpan> kept = filter.localStates();
  if (!kept) return "The filter cannot go back to " + scan + ": it keeps none (local_states_s).";
  return "The filter cannot go back to " + scan + ": it keeps those from " +
         core::numberText(kept->oldest_s) + " s to " + core::numberText(kept->newest_s) +
         " s (local_states_s).";
}

}  // namespace

CekfSlamNode::CekfSlamNode(const core::CekfSlamConfig& config,
                           const core::VehicleDescription& vehicle,
                           const core::PointCloudConfig& point_clouds)
    : map_frame_(vehicle.config.map_frame),
      settings_(core::settingsOf(config)),
      transforms_(tf_, causes_),
      filter_(config, vehicle.config, core::CekfSlam::GlobalUpdates::kBackground),
      merger_(config.merger),
      reader_(
          SensorMountings(tf_, vehicle.config.base_frame, laserFallback(vehicle), kMountingWait_s),
          GpsConverter(vehicle.config.gps_antenna.T_base_sensor().position()), point_clouds,
          config.use_time_increment, causes_),
      output_(handle_, config, vehicle.config.map_frame),
      queue_(kQueueCapacity),
      inputs_(handle_, config.motion_input, config.observation_input, config.gps.enabled, queue_,
              causes_) {
  filter_.keepLocalStates(config.local_states_s);
  ltrs_subscriber_ = handle_.subscribe("ltrs", 10, &CekfSlamNode::takeLtrs, this,
                                       ros::TransportHints().tcpNoDelay());
  pause_service_ = handle_.advertiseService("pause", &CekfSlamNode::pause, this);
  reset_service_ = handle_.advertiseService("reset", &CekfSlamNode::reset, this);
  advertisePatiently();
  advertiseStorage();
  patient_spinner_.start();
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", this, &CekfSlamNode::diagnoseInputs);
  diagnostics_.add("filter", this, &CekfSlamNode::diagnoseFilter);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  last_scan_wall_s_ = steadyNow();
  worker_ = std::thread(&CekfSlamNode::work, this);
}

CekfSlamNode::~CekfSlamNode() {
  patient_spinner_.stop();
  working_ = false;
  worker_.join();
}

void CekfSlamNode::work() {
  try {
    workOn();
  } catch (const std::exception& error) {
    endAfterFailure(std::string("The filter cannot go on: ") + error.what());
  }
}

void CekfSlamNode::workOn() {
  while (working_) {
    std::deque<SensorMessage> messages = queue_.takeAll(kPatience);
    const std::lock_guard<std::mutex> lock(mutex_);
    std::move(messages.begin(), messages.end(), std::back_inserter(backlog_));
    readBacklog();
    for (const core::SensorEvent& event : merger_.popReady(steadyNow())) process(event);
    if (steadyNow() - last_scan_wall_s_ > kSilence_s) output_.publishMapIfChanged(filter_);
  }
}

void CekfSlamNode::readBacklog() {
  while (!backlog_.empty() && working_) {
    const SensorMessage message = backlog_.front();
    const double now_s = steadyNow();
    if (paused_) {
      causes_.count("paused", "Messages are dropped while the node is paused.");
    } else {
      EventReader::Answer answer = reader_.read(message, now_s);
      if (answer.waiting) return;
      if (answer.event) {
        take(message, std::move(*answer.event), now_s);
      } else if (isScan(message)) {
        ++unreadable_scans_;
      }
    }
    backlog_.pop_front();
  }
}

void CekfSlamNode::take(const SensorMessage& message, core::SensorEvent event, double now_s) {
  if (isScan(message)) scan_headers_.remember(headerAt(core::timeOf(event), message));
  const std::size_t late = merger_.counts().out_of_order;
  merger_.push(std::move(event), now_s);
  for (std::size_t i = late; i < merger_.counts().out_of_order; ++i) {
    causes_.count("out of order",
                  "A message is older than what the filter has used, or its stamp is far from "
                  "those around it; it is dropped.");
  }
  for (const core::SensorEvent& ready : merger_.popReady(now_s)) process(ready);
}

void CekfSlamNode::process(const core::SensorEvent& event) {
  const std::optional<core::ScanOutcome> outcome = filter_.process(event);
  if (std::holds_alternative<core::ClockReset>(event)) {
    ROS_WARN("The time stamps ran back: another recording begins, with a new, empty map.");
    tf_.clear();  // it would refuse whatever is older than what it knows; static frames stay
    forgetRecording();
  } else if (outcome && outcome->accepted) {
    finish(*outcome);
  } else if (outcome) {
    // Its header must not be taken for that of another sensor's scan of the same stamp.
    scan_headers_.take(core::timeOf(event));
    causes_.count(causeOf(outcome->reason), "A scan is refused: " + outcome->reason);
  }
}

void CekfSlamNode::finish(const core::ScanOutcome& outcome) {
  last_scan_wall_s_ = steadyNow();
  health_ = outcome.health;
  worst_latency_ms_ = std::max(worst_latency_ms_, outcome.health.latency_ms);
  output_.publish(filter_, outcome, scan_headers_.take(outcome.pose.time_s), droppedScans());
}

void CekfSlamNode::forgetRecording() {
  reader_.reset();
  output_.reset(filter_);
}

std::size_t CekfSlamNode::droppedScans() const {
  return queue_.counts().dropped_scans + merger_.counts().dropped_scans + unreadable_scans_;
}

/// The vertices of the dense map's triangles must stay.
void CekfSlamNode::takeLtrs(const LtrMap& message) {
  std::vector<int> vertices;
  for (const Ltr& ltr : message.ltrs) {
    vertices.insert(vertices.end(), ltr.landmark_ids.begin(), ltr.landmark_ids.end());
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  filter_.pinLandmarks(message.header.stamp.toSec(), vertices);
}

bool CekfSlamNode::pause(Pause::Request& request, Pause::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  paused_ = request.pause;
  response.success = true;
  response.message =
      paused_ ? "Paused. What the vehicle moves until it is resumed stays unknown." : "Resumed.";
  return true;
}

bool CekfSlamNode::reset(Reset::Request&, Reset::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t landmarks = filter_.landmarkCount();
  queue_.clear();
  backlog_.clear();
  merger_.reset();
  filter_.reset();
  forgetRecording();
  response.success = true;
  response.message = "Forgot " + std::to_string(landmarks) +
                     " landmarks; the map begins where the vehicle stands now.";
  ROS_INFO_STREAM(response.message);
  return true;
}

void CekfSlamNode::advertisePatiently() {
  ros::NodeHandle handle(handle_);
  handle.setCallbackQueue(&patient_calls_);
  patient_services_ = {
      handle.advertiseService("get_joint_covariance", &CekfSlamNode::getJointCovariance, this),
      handle.advertiseService("suspend", &CekfSlamNode::suspend, this),
      handle.advertiseService("resume", &CekfSlamNode::resume, this)};
}

bool CekfSlamNode::getJointCovariance(GetJointCovariance::Request& request,
                                      GetJointCovariance::Response& response) {
  const auto answer = std::make_shared<std::promise<core::VehicleAmongLandmarks>>();
  std::future<core::VehicleAmongLandmarks> joint = answer->get_future();
  core::FilterKnowledge knowledge;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    response.message = problemOf(request, [this](int id) { return filter_.hasLandmark(id); });
    if (!response.message.empty()) return true;
    knowledge.calibration = filter_.calibration();
    filter_.requestVehicleAmongLandmarks(request.ids, [answer](core::VehicleAmongLandmarks known) {
      answer->set_value(std::move(known));
    });
  }
  knowledge.estimate = joint.get();  // scans go on meanwhile
  response = request.vehicle != 0U ? toMessage(knowledge, map_frame_)
                                   : toMessage(knowledge.estimate.landmarks, map_frame_);
  return true;
}

bool CekfSlamNode::suspend(Suspend::Request& request, Suspend::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  response.success = static_cast<std::uint8_t>(filter_.suspend(request.since.toSec()));
  response.message = suspensionText(request.since.toSec(), response.success != 0U, filter_);
  if (response.success != 0U) ROS_WARN_STREAM(response.message);
  return true;
}

bool CekfSlamNode::resume(Resume::Request& request, Resume::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double from_s = request.since.toSec();
  core::Resumption resumption;
  if (request.way == Resume::Request::CLOSING) {
    resumption = filter_.resume(from_s, fromMessage(request.path));
  } else if (request.way == Resume::Request::ELSEWHERE) {
    resumption = filter_.resumeElsewhere(from_s, fromMessage(request.path));
  } else if (request.way == Resume::Request::WITHOUT_CLOSING) {
    const bool from_waiting = request.since.isZero();
    if (from_waiting && !filter_.isSuspended()) {
      response.message = "The filter does not wait anywhere.";
      return true;
    }
    resumption =
        filter_.resumeWithoutClosing(from_waiting ? filter_.localStates()->newest_s : from_s);
  } else {
    response.message =
        "There is no way " + std::to_string(request.way) + " of resuming; see hymm/Resume.srv.";
    return true;
  }
  response.success = static_cast<std::uint8_t>(resumption.accepted());
  response.message = resumption.reason;
  ROS_WARN_STREAM("Resuming: " << response.message);
  return true;
}

}  // namespace hymm
