#include "ros/relocaliser_conversions.h"

#include <algorithm>

#include "ros/pose_conversions.h"
#include "ros/time_conversions.h"

namespace hymm {
namespace {

std::string nameOf(core::SearchState state) {
  switch (state) {
    case core::SearchState::kIdle:
      return RelocaliserHealth::IDLE;
    case core::SearchState::kSearching:
      return RelocaliserHealth::SEARCHING;
    case core::SearchState::kAccepted:
      return RelocaliserHealth::ACCEPTED;
    case core::SearchState::kRefused:
      return RelocaliserHealth::REFUSED;
    case core::SearchState::kFailed:
      return RelocaliserHealth::FAILED;
  }
  return "";
}

std::uint32_t unsignedOf(std::size_t count) { return static_cast<std::uint32_t>(count); }

void describe(const core::RelocaliserOutcome& outcome, RelocaliserHealth& message) {
  message.converged = outcome.converged;
  message.particles = unsignedOf(outcome.particles);
  message.effective_number = outcome.effective_number;
  message.modes = unsignedOf(outcome.modes.size());
  message.heaviest = outcome.modes.empty() ? 0.0 : outcome.modes.front().share;
  message.observations = static_cast<std::uint32_t>(outcome.explanation.observations);
  message.explained = static_cast<std::uint32_t>(outcome.explanation.explained);
  message.missed = unsignedOf(outcome.explanation.missed.size());
  message.held_scans = static_cast<std::uint32_t>(outcome.held_scans);
}

}  // namespace

RelocaliserHealth toMessage(const core::SearchReport& report, const std::string& frame_id) {
  RelocaliserHealth message;
  message.header.stamp = toRosTime(report.time_s);
  message.header.frame_id = frame_id;
  message.state = nameOf(report.state);
  message.reason = report.reason;
  message.order = report.order;
  message.anywhere = report.anywhere;
  if (report.outcome) describe(*report.outcome, message);
  return message;
}

core::RelocaliserEvidence evidenceFrom(const RelocaliserHealth& message) {
  using State = core::RelocaliserEvidence::State;
  core::RelocaliserEvidence evidence;
  evidence.reason = message.reason;
  if (message.state == RelocaliserHealth::ACCEPTED) evidence.state = State::kAccepted;
  if (message.state == RelocaliserHealth::REFUSED) evidence.state = State::kRefused;
  if (message.state == RelocaliserHealth::FAILED) evidence.state = State::kFailed;
  return evidence;
}

geometry_msgs::PoseArray toMessage(const core::Relocaliser& relocaliser, std::size_t most) {
  geometry_msgs::PoseArray message;
  const core::ParticleSet& particles = relocaliser.particles();
  const std::size_t step = std::max<std::size_t>(1, (particles.size() + most - 1) / most);
  for (std::size_t i = 0; i < particles.size(); i += step) {
    message.poses.push_back(toPoseMessage(relocaliser.map().T_map_local * particles.pose(i)));
  }
  return message;
}

nav_msgs::Path toMessage(const std::vector<core::PlaceAtScan>& path, const std::string& frame_id) {
  nav_msgs::Path message;
  message.header.frame_id = frame_id;
  for (const core::PlaceAtScan& place : path) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = toRosTime(place.time_s);
    pose.header.frame_id = frame_id;
    pose.pose = toPoseMessage(place.T_map_base);
    message.poses.push_back(pose);
  }
  return message;
}

std::vector<core::PlaceAtScan> fromMessage(const nav_msgs::Path& message) {
  std::vector<core::PlaceAtScan> path;
  for (const geometry_msgs::PoseStamped& pose : message.poses) {
    path.push_back({pose.header.stamp.toSec(), fromMessage(pose.pose)});
  }
  return path;
}

}  // namespace hymm
