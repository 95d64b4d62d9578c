#include "nodes/playback_node.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include <ros/master.h>
#include <std_srvs/SetBool.h>

#include "ros/bag_errors.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr double kConnect_s = 1.0;  // from being registered to being connected
constexpr double kSilence_s = 2.0;  // rosbag repeats /clock at 10 Hz or more, paused or not
constexpr double kPoll_s = 0.1;

void sleep(double duration_s) { ros::WallDuration(duration_s).sleep(); }

/// All nodes that subscribe to anything.
std::set<std::string> subscribedNodes() {
  std::set<std::string> nodes;
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return nodes;
  for (int topic = 0; topic < state[1].size(); ++topic) {
    for (int i = 0; i < state[1][topic][1].size(); ++i) {
      nodes.insert(static_cast<std::string>(state[1][topic][1][i]));
    }
  }
  return nodes;
}

}  // namespace

PlaybackNode::PlaybackNode(const PlaybackConfig& config) : config_(config) {
  std::istringstream names(config.listeners);
  for (std::string name; names >> name;) listeners_.push_back(name);
  clock_ = handle_.subscribe<rosgraph_msgs::Clock>(
      "/clock", 10, [this](const rosgraph_msgs::Clock::ConstPtr&) { clock_wall_s_ = steadyNow(); });
  grid_ = handle_.subscribe<GridStatus>(
      "grid_status", 1000, [this](const GridStatus::ConstPtr&) { result_wall_s_ = steadyNow(); });
  health_ = handle_.subscribe<FilterHealth>(
      "cekf/health", 1000, [this](const FilterHealth::ConstPtr&) { result_wall_s_ = steadyNow(); });
}

void PlaybackNode::run() {
  if (!config_.bag.empty()) checkBag(config_.bag);
  waitForAll();
  startPlayer();
  waitForEnd();
}

std::string PlaybackNode::missing() const {
  const std::set<std::string> nodes = subscribedNodes();
  std::string names;
  for (const std::string& listener : listeners_) {
    const std::string name = handle_.resolveName(listener);
    if (nodes.count(name) == 0) names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

void PlaybackNode::waitForAll() {
  const double begin_s = steadyNow();
  for (std::string names = missing(); !names.empty() && ros::ok(); names = missing()) {
    if (steadyNow() - begin_s > config_.start_timeout_s) {
      throw std::runtime_error("the recording is not played, because these nodes do not listen: " +
                               names);
    }
    sleep(kPoll_s);
  }
  sleep(kConnect_s);
}

void PlaybackNode::startPlayer() {
  const std::string service = handle_.resolveName(config_.player) + "/pause_playback";
  const ros::WallDuration wait(config_.start_timeout_s);
  const double begin_s = steadyNow();
  while (ros::ok() && !ros::service::exists(service, false)) {
    if (steadyNow() - begin_s > wait.toSec()) {
      throw std::runtime_error("the recording is not played: there is no service " + service);
    }
    sleep(kPoll_s);
  }
  std_srvs::SetBool pause;
  pause.request.data = 0U;
  if (ros::ok() && !ros::service::call(service, pause)) {
    throw std::runtime_error("the recording is not played: " + service + " does not answer");
  }
  ROS_INFO("Playing.");
}

void PlaybackNode::waitForEnd() {
  clock_wall_s_ = result_wall_s_ = steadyNow();
  while (ros::ok()) {
    ros::spinOnce();
    const double newest_s = std::max(clock_wall_s_, result_wall_s_);
    if (steadyNow() - newest_s > kSilence_s) break;
    sleep(kPoll_s);
  }
  if (ros::ok()) ROS_INFO("The recording has ended, and all of it is processed.");
}

}  // namespace hymm
