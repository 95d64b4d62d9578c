#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <ros/console.h>
#include <ros/node_handle.h>

#include "ros/goal_ledger.h"
#include "ros/steady_time.h"

namespace hymm {

/// Serves an action of which one goal is worked on at a time, in a thread of its own, and the
/// newest replaces the others; actionlib's clients find what they expect.
///
/// Not actionlib::SimpleActionServer: its goalCallback publishes the result of a goal whose cancel
/// came first, publishing erases statuses that are old by their stamps, this goal's perhaps among
/// them, and goalCallback then goes on writing to it. Whoever sends a cancel with an old stamp and
/// then its goal ends the process by that. Here nothing refers to a status but the ledger.
template <class Action>
class SingleGoalServer {
 public:
  using ActionGoal = typename Action::_action_goal_type;
  using ActionResult = typename Action::_action_result_type;
  using ActionFeedback = typename Action::_action_feedback_type;
  using Goal = typename ActionGoal::_goal_type;
  using Result = typename ActionResult::_result_type;
  using Feedback = typename ActionFeedback::_feedback_type;
  struct End {
    std::uint8_t state = GoalLedger::Status::ABORTED;
    std::string text;
    Result result;
  };
  using Execute = std::function<End(const Goal&)>;

  SingleGoalServer(const ros::NodeHandle& parent, const std::string& name, Execute execute)
      : handle_(parent, name), execute_(std::move(execute)) {
    result_publisher_ = handle_.advertise<ActionResult>("result", kQueue);
    feedback_publisher_ = handle_.advertise<ActionFeedback>("feedback", kQueue);
    status_publisher_ = handle_.advertise<actionlib_msgs::GoalStatusArray>("status", kQueue, true);
    goal_subscriber_ = handle_.subscribe("goal", kQueue, &SingleGoalServer::takeGoal, this);
    cancel_subscriber_ = handle_.subscribe("cancel", kQueue, &SingleGoalServer::takeCancel, this);
    status_timer_ = handle_.createSteadyTimer(ros::WallDuration(kStatusEvery_s),
                                              [this](const ros::SteadyTimerEvent&) {
                                                const std::lock_guard<std::mutex> lock(mutex_);
                                                publishStatus();
                                              });
    worker_ = std::thread(&SingleGoalServer::work, this);
  }

  ~SingleGoalServer() { shutdown(); }

  SingleGoalServer(const SingleGoalServer&) = delete;
  SingleGoalServer& operator=(const SingleGoalServer&) = delete;

  /// Ends the goal that is worked on, and takes none any more.
  void shutdown() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    if (worker_.joinable()) worker_.join();
  }

  /// Of the goal that is worked on; from within `execute`.
  bool isAskedToEnd() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stopping_ || ledger_.isAskedToEnd();
  }

  void publishFeedback(const Feedback& feedback) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!ledger_.current()) return;
    ActionFeedback message;
    message.header.stamp = ros::Time::now();
    message.status = *ledger_.current();
    message.feedback = feedback;
    feedback_publisher_.publish(message);
  }

 private:
  static constexpr std::uint32_t kQueue = 50;
  static constexpr double kStatusEvery_s = 0.2;

  void takeGoal(const boost::shared_ptr<const ActionGoal>& goal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const GoalLedger::Taken taken = ledger_.take(goal->goal_id, ros::Time::now(), steadyNow());
    if (taken.waits) waiting_ = goal;
    tell(taken.ended);
    changed_.notify_all();
  }

  void takeCancel(const actionlib_msgs::GoalID& id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    tell(ledger_.cancel(id, ros::Time::now(), steadyNow()));
  }

  void work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || ledger_.hasWaiting(); });
      if (stopping_) return;
      const boost::shared_ptr<const ActionGoal> goal = waiting_;
      ledger_.begin("It is worked on.");
      publishStatus();
      lock.unlock();
      const End end = execute(goal->goal);
      lock.lock();
      publishResult(ledger_.end(end.state, end.text, steadyNow()), end.result);
      publishStatus();
    }
  }

  /// A goal that ends in an exception is aborted with its words: the node goes on.
  End execute(const Goal& goal) {
    try {
      return execute_(goal);
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM("A goal of " << handle_.getNamespace() << " failed: " << error.what());
      End end;
      end.text = error.what();
      return end;
    }
  }

  // What follows is called with the mutex held, so that clients hear of changes in their order.

  void tell(const std::vector<GoalLedger::Status>& ended) {
    for (const GoalLedger::Status& status : ended) publishResult(status, Result());
    publishStatus();
  }

  void publishResult(const GoalLedger::Status& status, const Result& result) {
    ActionResult message;
    message.header.stamp = ros::Time::now();
    message.status = status;
    message.result = result;
    result_publisher_.publish(message);
  }

  void publishStatus() {
    actionlib_msgs::GoalStatusArray message;
    message.header.stamp = ros::Time::now();
    message.status_list = ledger_.statuses(steadyNow());
    status_publisher_.publish(message);
  }

  ros::NodeHandle handle_;
  Execute execute_;
  ros::Publisher result_publisher_, feedback_publisher_, status_publisher_;

  std::mutex mutex_;  ///< over what follows
  std::condition_variable changed_;
  GoalLedger ledger_;
  boost::shared_ptr<const ActionGoal> waiting_;  ///< the last goal taken
  bool stopping_ = false;

  ros::Subscriber goal_subscriber_, cancel_subscriber_;
  ros::SteadyTimer status_timer_;
  std::thread worker_;
};

}  // namespace hymm
