#include "ros/goal_ledger.h"

#include <algorithm>

namespace hymm {
namespace {

constexpr double kTold_s = 5.0;  ///< as actionlib's servers do
constexpr std::size_t kMostEnded = 100;
constexpr std::size_t kMostEarlyCancels = 100;

/// As actionlib has it: neither id nor stamp means all, a stamp all goals up to it.
bool concerns(const actionlib_msgs::GoalID& cancel, const actionlib_msgs::GoalID& goal) {
  const bool has_stamp = cancel.stamp != ros::Time();
  return (cancel.id.empty() && !has_stamp) || cancel.id == goal.id ||
         (has_stamp && goal.stamp <= cancel.stamp);
}

}  // namespace

GoalLedger::Taken GoalLedger::take(actionlib_msgs::GoalID id, const ros::Time& now,
                                   double steady_now_s) {
  if (isKnown(id.id)) return {};
  if (now < cancelled_until_) cancelled_until_ = ros::Time();  // another recording
  if (id.stamp == ros::Time()) id.stamp = now;
  if (id.id.empty()) id.id = id_generator_.generateID().id;
  Status status;
  status.goal_id = id;
  status.status = Status::PENDING;
  Taken taken;
  if (wasCancelled(id)) {
    taken.ended.push_back(
        finish(status, Status::RECALLED, "It was cancelled before it came.", steady_now_s));
    return taken;
  }
  if (waiting_) {
    taken.ended.push_back(
        finish(*waiting_, Status::RECALLED, "Another goal came after it.", steady_now_s));
  }
  waiting_ = status;
  if (current_) current_->status = Status::PREEMPTING;
  taken.waits = true;
  return taken;
}

std::vector<GoalLedger::Status> GoalLedger::cancel(const actionlib_msgs::GoalID& id,
                                                   const ros::Time& now, double steady_now_s) {
  if (!id.id.empty() && !isKnown(id.id)) {
    early_cancels_.push_back(id.id);
    if (early_cancels_.size() > kMostEarlyCancels) early_cancels_.pop_front();
  }
  // A stamp in the future does not cancel what is asked for from now on.
  cancelled_until_ = std::max(cancelled_until_, std::min(id.stamp, now));
  if (current_ && concerns(id, current_->goal_id)) current_->status = Status::PREEMPTING;
  if (!waiting_ || !concerns(id, waiting_->goal_id)) return {};
  const Status status = *waiting_;
  waiting_.reset();
  return {finish(status, Status::RECALLED, "It was cancelled.", steady_now_s)};
}

void GoalLedger::begin(const std::string& text) {
  current_ = waiting_;
  waiting_.reset();
  current_->status = Status::ACTIVE;
  current_->text = text;
}

GoalLedger::Status GoalLedger::end(std::uint8_t state, const std::string& text,
                                   double steady_now_s) {
  const Status status = *current_;
  current_.reset();
  return finish(status, state, text, steady_now_s);
}

std::vector<GoalLedger::Status> GoalLedger::statuses(double steady_now_s) {
  while (!ended_.empty() && steady_now_s - ended_.front().since_s > kTold_s) ended_.pop_front();
  std::vector<Status> all;
  for (const Ended& ended : ended_) all.push_back(ended.status);
  if (current_) all.push_back(*current_);
  if (waiting_) all.push_back(*waiting_);
  return all;
}

bool GoalLedger::isKnown(const std::string& id) const {
  return (waiting_ && waiting_->goal_id.id == id) || (current_ && current_->goal_id.id == id) ||
         std::any_of(ended_.begin(), ended_.end(),
                     [&](const Ended& ended) { return ended.status.goal_id.id == id; });
}

bool GoalLedger::wasCancelled(const actionlib_msgs::GoalID& id) {
  const auto early = std::find(early_cancels_.begin(), early_cancels_.end(), id.id);
  if (early != early_cancels_.end()) {
    early_cancels_.erase(early);
    return true;
  }
  // 0 means that nothing was cancelled by its stamp; goals bear it while a simulated clock stands.
  return cancelled_until_ != ros::Time() && id.stamp <= cancelled_until_;
}

GoalLedger::Status GoalLedger::finish(Status status, std::uint8_t state, const std::string& text,
                                      double steady_now_s) {
  status.status = state;
  status.text = text;
  ended_.push_back({status, steady_now_s});
  if (ended_.size() > kMostEnded) ended_.pop_front();
  return status;
}

}  // namespace hymm
