#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <actionlib/goal_id_generator.h>
#include <actionlib_msgs/GoalID.h>
#include <actionlib_msgs/GoalStatusArray.h>
#include <ros/time.h>

namespace hymm {

/// What becomes of the goals of an action of which one is worked on at a time and the newest waits:
/// the states of actionlib's protocol. Goals rank by when they come, not by their stamps: one of
/// the far future shuts nobody out. Of stamps, only cancels make use, as the protocol says.
class GoalLedger {
 public:
  using Status = actionlib_msgs::GoalStatus;

  struct Taken {
    bool waits = false;         ///< to be worked on; not where the id is known, or was cancelled
    std::vector<Status> ended;  ///< each with a result to be told
  };

  /// Takes a new goal, in place of one that waits; the one that is worked on is asked to end.
  Taken take(actionlib_msgs::GoalID id, const ros::Time& now, double steady_now_s);
  /// Returns whom that ends. A cancel of an id that is not known yet waits for its goal.
  std::vector<Status> cancel(const actionlib_msgs::GoalID& id, const ros::Time& now,
                             double steady_now_s);
  bool hasWaiting() const { return waiting_.has_value(); }
  /// The goal that waits is the one that is worked on from now on.
  void begin(const std::string& text);
  const std::optional<Status>& current() const { return current_; }
  bool isAskedToEnd() const { return current_ && current_->status == Status::PREEMPTING; }
  /// Ends the goal that is worked on.
  Status end(std::uint8_t state, const std::string& text, double steady_now_s);
  /// Those at work, and those that ended within the last seconds, so that clients hear of it.
  std::vector<Status> statuses(double steady_now_s);

 private:
  struct Ended {
    Status status;
    double since_s;  ///< by a steady clock
  };

  bool isKnown(const std::string& id) const;
  bool wasCancelled(const actionlib_msgs::GoalID& id);
  Status finish(Status status, std::uint8_t state, const std::string& text, double steady_now_s);

  std::optional<Status> waiting_, current_;
  std::deque<Ended> ended_;
  std::deque<std::string> early_cancels_;  ///< ids whose goals have not come
  ros::Time cancelled_until_;              ///< stamps of goals that come too late
  actionlib::GoalIDGenerator id_generator_;
};

}  // namespace hymm
