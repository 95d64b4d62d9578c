// What DoorPlannerNode answers: requests, whichever way they come.

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/door_planner_node.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr double kFeedbackEvery_s = 0.1;  ///< at most; searches ask far more often

/// Service responses and action results have the same fields.
template <class Message>
void fill(const core::Plan& plan, const std_msgs::Header& header, Message& message) {
  message.success = plan.ok();
  message.status = core::nameOf(plan.status);
  message.message = plan.sentence;
  message.path = pathMessage(plan.path, header, plan.points);
  message.refined = plan.is_refined;
  message.cost = plan.cost;
  message.cost_with_uncertainty = plan.cost_with_uncertainty;
  message.length = plan.length_m;
  message.worst_shape_factor = plan.worst_shape_factor;
  message.doors = plan.doors;
}

Eigen::Vector2d placeOf(const geometry_msgs::Point& point) { return {point.x, point.y}; }

/// Nothing where a message leaves the orientation out.
std::optional<double> headingOf(const geometry_msgs::Quaternion& q) {
  if (q.x == 0.0 && q.y == 0.0 && q.z == 0.0 && q.w == 0.0) return std::nullopt;
  return yawOf(q);
}

core::Plan refusal(core::PlanStatus status, const std::string& sentence) {
  core::Plan plan;
  plan.status = status;
  plan.sentence = sentence;
  return plan;
}

}  // namespace

std::optional<core::Plan> DoorPlannerNode::addWhatIsKnown(const Wish& wish,
                                                          core::PlanRequest& request) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!wish.start && !vehicle_) {
    return refusal(core::PlanStatus::kBadRequest,
                   "No pose has come on 'pose' yet to start from; give a start.");
  }
  request.start = wish.start ? *wish.start : vehicle_->position();
  request.start_heading = wish.start ? wish.start_heading : vehicle_->yaw_rad;
  if (!(wish.lowest_information > 0.0)) return std::nullopt;
  // The largest set that gives at least that much.
  const auto set = level_sets_.lower_bound(wish.lowest_information);
  if (set == level_sets_.end() || !set->second) {
    return refusal(core::PlanStatus::kBelowInformation,
                   "No level set of at least that information has come on 'level_sets'; "
                   "is information_map running, with such a value?");
  }
  request.is_informed = [informed = set->second](const Eigen::Vector2d& place) {
    return informed->contains(place);
  };
  return std::nullopt;
}

core::Plan DoorPlannerNode::plan(const Wish& wish, const std::function<bool()>& cancelled) {
  core::PlanRequest request;
  request.goal = wish.goal;
  request.goal_heading = wish.goal_heading;
  request.weights = wish.weights;
  request.is_refined = wish.is_refined && config_.refinement.enabled;
  request.tolerance_m = wish.tolerance_m < 0.0 ? config_.tolerance_m : wish.tolerance_m;
  const std::optional<core::Plan> refused = addWhatIsKnown(wish, request);
  const double begin_s = steadyNow();
  const double end_s = begin_s + config_.time_limit_s;
  request.interrupted = [end_s, &cancelled] {
    if (cancelled && cancelled()) return core::PlanStatus::kCancelled;
    return steadyNow() > end_s ? core::PlanStatus::kTimeout : core::PlanStatus::kOk;
  };
  core::Plan answer = refused ? *refused : planner_.plan(request);
  const std::lock_guard<std::mutex> lock(mutex_);
  ++answers_[core::nameOf(answer.status)];
  answer_ms_ = 1e3 * (steadyNow() - begin_s);
  worst_answer_ms_ = std::max(worst_answer_ms_, answer_ms_);
  return answer;
}

void DoorPlannerNode::keep(const Wish& wish, const core::Plan& plan, std::size_t maps_begun) {
  const std::lock_guard<std::mutex> lock(mutex_);
  live_.reset();
  if (plan.ok() && maps_begun == maps_begun_) {
    live_ = LivePlan{wish, plan, {}};
    publishLive(*live_);
    return;
  }
  if (plan.ok()) {
    ROS_WARN("The map began anew while the plan was made; it is not kept.");
  } else {
    ROS_WARN_STREAM(core::nameOf(plan.status) << ": " << plan.sentence);
  }
  plan_publisher_.publish(pathMessage({}, header(), {}));
}

void DoorPlannerNode::takeGoal(const geometry_msgs::PoseStamped& message) {
  if (!isOurFrame(message.header.frame_id, "move_base_simple/goal")) return;
  Wish wish;
  wish.goal = placeOf(message.pose.position);
  wish.goal_heading = headingOf(message.pose.orientation);
  const std::size_t maps_begun = mapsBegun();
  keep(wish, plan(wish), maps_begun);
  watch();
}

void DoorPlannerNode::watch() {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_news_ = true;
  changed_.notify_all();
}

bool DoorPlannerNode::planPath(PlanPath::Request& request, PlanPath::Response& response) {
  Wish wish;
  if (!request.from_pose) wish.start = placeOf(request.start);
  wish.goal = placeOf(request.goal);
  wish.tolerance_m = request.tolerance;
  wish.lowest_information = request.lowest_information;
  wish.weights = request.weights;
  wish.is_refined = !request.unrefined;
  fill(plan(wish), header(), response);
  return true;
}

bool DoorPlannerNode::makePlan(nav_msgs::GetPlan::Request& request,
                               nav_msgs::GetPlan::Response& response) {
  response.plan.header = header();
  for (const std::string& frame : {request.start.header.frame_id, request.goal.header.frame_id}) {
    if (!frame.empty() && !isOurFrame(frame, "make_plan")) return true;
  }
  Wish wish;
  wish.start = placeOf(request.start.pose.position);
  wish.goal = placeOf(request.goal.pose.position);
  wish.start_heading = headingOf(request.start.pose.orientation);
  wish.goal_heading = headingOf(request.goal.pose.orientation);
  wish.tolerance_m = std::isfinite(request.tolerance) ? double{request.tolerance} : -1.0;
  const core::Plan answer = plan(wish);
  if (!answer.ok()) ROS_WARN_STREAM("make_plan: " << answer.sentence);
  response.plan = pathMessage(answer.path, header(), answer.points);
  return true;
}

DoorPlannerNode::PlanServer::End DoorPlannerNode::executeAction(const PlanPathGoal& goal) {
  const double begin_s = steadyNow();
  Wish wish;
  if (!goal.from_pose) wish.start = placeOf(goal.start);
  wish.goal = placeOf(goal.goal);
  wish.tolerance_m = goal.tolerance;
  wish.lowest_information = goal.lowest_information;
  wish.weights = goal.weights;
  wish.is_refined = !goal.unrefined;
  const std::size_t maps_begun = mapsBegun();
  double next_feedback_s = 0.0;
  const core::Plan answer = plan(wish, [&] {
    PlanPathFeedback feedback;
    feedback.seconds = steadyNow() - begin_s;
    if (feedback.seconds >= next_feedback_s) {
      action_->publishFeedback(feedback);
      next_feedback_s = feedback.seconds + kFeedbackEvery_s;
    }
    return action_->isAskedToEnd();
  });
  using Status = GoalLedger::Status;
  PlanServer::End end;
  end.text = answer.sentence;
  fill(answer, header(), end.result);
  if (answer.status == core::PlanStatus::kCancelled) {
    end.state = Status::PREEMPTED;
    return end;
  }
  keep(wish, answer, maps_begun);
  watch();
  end.state = answer.ok() ? Status::SUCCEEDED : Status::ABORTED;
  return end;
}

}  // namespace hymm
