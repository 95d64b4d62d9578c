#include "nodes/playback_node.h"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include <std_srvs/SetBool.h>

#include "ros/bag_errors.h"
#include "ros/node_graph.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr double kSettle_s = 1.0;     // within which a node that begins subscribes again
constexpr double kConnect_s = 20.0;   // a publisher that does not answer by then is gone
constexpr double kSilence_s = 2.0;    // rosbag repeats /clock at 10 Hz or more, paused or not
constexpr double kAdvertise_s = 5.0;  // from when the player lives to when it tells its topics
// A player that lags behind, on a busy machine, sends its last messages without a word of /clock.
constexpr double kUnheard_s = 2.0;
constexpr double kPoll_s = 0.1;
constexpr double kTell_s = 1.0;  // between two diagnoses

std::string joined(const std::string& list, const std::string& word) {
  return list.empty() ? word : list + ", " + word;
}

}  // namespace

PlaybackNode::PlaybackNode(const PlaybackConfig& config) : config_(config) {
  std::istringstream names(config.listeners);
  for (std::string name; names >> name;) listeners_.push_back(name);
  const auto listen = [this](const char* topic, std::uint32_t queue, double& last_s, auto message) {
    using Message = decltype(message);
    return traffic_.subscribe<Message>(
        handle_, topic, queue,
        [&last_s](const boost::shared_ptr<const Message>&) { last_s = steadyNow(); });
  };
  clock_ = traffic_.subscribe(handle_, "/clock", 10, &PlaybackNode::takeClock, this,
                              ros::TransportHints());
  grid_ = listen("grid_status", 1000, result_wall_s_, GridStatus());
  health_ = listen("cekf/health", 1000, result_wall_s_, FilterHealth());
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("playback", this, &PlaybackNode::diagnose);
}

void PlaybackNode::run() {
  lookIntoBag();
  waitForAll();
  startPlayer();
  waitForEnd();
}

void PlaybackNode::lookIntoBag() {
  if (config_.bag.empty()) return;
  checkBag(config_.bag);
  if (config_.bag.find_first_of("\"\\") != std::string::npos) {
    throw core::InputError(config_.bag +
                           ": a quote or a backslash in the name of a bag cannot be handed to the "
                           "player; rename it, or its folder.");
  }
  const std::optional<PlayerArguments> arguments = parsePlayerArguments(config_.play_args);
  if (arguments && !arguments->loops) span_ = playedSpan(config_.bag, *arguments);
}

void PlaybackNode::takeClock(const rosgraph_msgs::Clock& message) {
  const double now_s = message.clock.toSec();
  const double now_wall_s = steadyNow();
  if (clock_s_ && now_s > *clock_s_) {
    played_s_ += now_s - *clock_s_;
    played_wall_s_ += now_wall_s - clock_wall_s_;
  }
  clock_s_ = now_s;
  clock_wall_s_ = now_wall_s;
}

/// Topics may be renamed, one of them from "dead_reckoning"; nodes are not.
std::string PlaybackNode::nodeName(const std::string& name) const {
  return handle_.resolveName(name, false);
}

std::string PlaybackNode::missing() const {
  const std::set<std::string> nodes = presentGraph().subscribedNodes();
  std::string names;
  for (const std::string& listener : listeners_) {
    const std::string name = nodeName(listener);
    if (nodes.count(name) == 0) names = joined(names, name);
  }
  return names;
}

void PlaybackNode::waitForAll() {
  const double begin_s = steadyNow();
  state_ = "Waits for the nodes that are to listen";
  for (std::string names = missing(); !names.empty() && ros::ok(); names = missing()) {
    if (steadyNow() - begin_s > config_.start_timeout_s) {
      throw std::runtime_error("the recording is not played, because these nodes do not listen: " +
                               names);
    }
    pause();
  }
}

/// From every node that publishes to every listener: to be registered is not to be connected, and
/// what is sent in between is lost. A node that begins subscribes one by one, so that all has to
/// stay as it is for a while.
void PlaybackNode::waitForLinks() {
  state_ = "Waits for the connections between the nodes";
  const double begin_s = steadyNow();
  double last_missing_s = begin_s;
  NodesByTopic subscribers;
  while (ros::ok() && steadyNow() - last_missing_s < kSettle_s) {
    pause();
    std::string missing;
    const NodeGraph graph = presentGraph();
    if (graph.subscribers.empty()) missing = "all, as the master does not answer";
    if (graph.subscribers != subscribers) missing = joined(missing, "new ones");
    subscribers = graph.subscribers;
    for (const std::string& listener : listeners_) {
      for (const std::string& link : missingLinks(graph, nodeName(listener))) {
        missing = joined(missing, link + " to " + listener);
      }
    }
    if (missing.empty()) continue;
    last_missing_s = steadyNow();
    if (last_missing_s - begin_s > kConnect_s) {
      ROS_WARN_STREAM(
          "These connections do not come about; the recording is played all the same: " << missing);
      return;
    }
  }
}

void PlaybackNode::startPlayer() {
  state_ = "Waits for the player";
  const std::string service = nodeName(config_.player) + "/pause_playback";
  const ros::WallDuration wait(config_.start_timeout_s);
  const double begin_s = steadyNow();
  while (ros::ok() && !ros::service::exists(service, false)) {
    if (steadyNow() - begin_s > wait.toSec()) {
      throw std::runtime_error("the recording is not played: there is no service " + service);
    }
    pause();
  }
  waitForLinks();
  requireSensors();
  waitForLinks();
  std_srvs::SetBool pause;
  pause.request.data = 0U;
  if (ros::ok() && !ros::service::call(service, pause)) {
    throw std::runtime_error("the recording is not played: " + service + " does not answer");
  }
  ROS_INFO("Playing.");
}

/// Names under which sensors are listened to, by the nodes that take them in, and nobody publishes.
std::string PlaybackNode::silentSensors() const {
  const NodeGraph graph = presentGraph();
  std::string names;
  for (const char* sensor : {"scan", "points", "detections", "odom", "dead_reckoning"}) {
    const std::string topic = handle_.resolveName(sensor);
    const auto listening = graph.subscribers.find(topic);
    if (listening == graph.subscribers.end() || graph.publishers.count(topic) > 0) continue;
    for (const char* node : {"cekf_slam", "dead_reckoning"}) {
      if (listening->second.count(nodeName(node)) == 0) continue;
      names = joined(names, topic + " (for " + node + ")");
    }
  }
  return names;
}

/// The player is there, but tells its topics a moment later.
void PlaybackNode::requireSensors() const {
  const double begin_s = steadyNow();
  std::string names = silentSensors();
  while (!names.empty() && ros::ok()) {
    if (steadyNow() - begin_s > kAdvertise_s) {
      throw core::InputError(
          "the recording is not played, because nobody publishes " + names +
          (config_.bag.empty() ? "" : ". The bag has " + topicsOf(config_.bag)) +
          ". Tell the robot's names of topics, as scan_topic:=/front/scan, "
          "odom_topic:=/wheel/odom, "
          "or other inputs by motion_input and observation_input of cekf_slam; a bag of a car's "
          "dead_reckoning alone needs dead_reckoning:=true");
    }
    ros::WallDuration(kPoll_s).sleep();
    names = silentSensors();
  }
}

void PlaybackNode::waitForEnd() {
  clock_wall_s_ = result_wall_s_ = steadyNow();
  state_ = "The recording is played";
  while (ros::ok()) {
    ros::spinOnce();
    const double newest_s = std::max(clock_wall_s_, result_wall_s_);
    if (steadyNow() - newest_s > kSilence_s) break;
    pause();
  }
  if (!ros::ok()) return;
  requireEnd();
  if (span_) {
    ROS_INFO("The recording has ended, and all of it is processed.");
  } else {
    ROS_INFO("The player has ended, and all that it played is processed.");
  }
}

/// A player that fails, or that a user stops, falls silent as one does that has played it all.
void PlaybackNode::requireEnd() const {
  if (!span_) return;
  const double rate = played_wall_s_ > 0.0 ? played_s_ / played_wall_s_ : 1.0;
  const double reached_s = clock_s_.value_or(span_->begin_s);
  if (reached_s >= span_->end_s - rate * kUnheard_s) return;
  std::ostringstream sentence;
  sentence << std::fixed << std::setprecision(1)
           << "the recording is not played to its end: the player ended at "
           << reached_s - span_->begin_s << " s of " << span_->end_s - span_->begin_s
           << " s, because it failed or was stopped. What it played is processed.";
  throw std::runtime_error(sentence.str());
}

/// Between two looks.
void PlaybackNode::pause() {
  if (steadyNow() - told_wall_s_ > kTell_s) {
    told_wall_s_ = steadyNow();
    diagnostics_.force_update();
  }
  ros::WallDuration(kPoll_s).sleep();
}

void PlaybackNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, state_);
  status.add("nodes that are to listen", config_.listeners);
}

}  // namespace hymm
