#pragma once

#include <string>

#include <hymm/LandmarkMap.h>
#include <hymm/LandmarkUpdate.h>
#include <ros/ros.h>

#include "pipeline/landmark_mirror.h"

namespace hymm {

/// The present landmark map, from `landmarks` and `landmark_updates`, for displays. Callbacks come
/// in the thread that spins the node handle's queue: RViz's own.
class LandmarkFeed {
 public:
  /// Begins anew with these topics; an empty name is not subscribed to.
  void subscribe(ros::NodeHandle& handle, const std::string& map_topic,
                 const std::string& update_topic);
  /// Ends, and forgets the map.
  void stop();
  /// Forgets the map.
  void clear();

  const core::LandmarkMap& map() const { return mirror_.map(); }
  bool hasMap() const { return !frame_.empty(); }
  const std::string& frame() const { return frame_; }

  /// Whether the map or its state changed since this was last asked.
  bool takeNews();

  /// What to tell of the map: a count, or what is wrong and what to do.
  struct State {
    bool ok = false;
    std::string sentence;
  };
  State state() const;

 private:
  void takeMap(const LandmarkMap& message);
  void takeUpdate(const LandmarkUpdate& message);
  bool isUsable(const std::vector<core::LandmarkEstimate>& landmarks, const char* what);

  std::string map_topic_;
  ros::Subscriber map_subscriber_, update_subscriber_;
  core::LandmarkMirror mirror_;
  std::string frame_;  ///< empty until a map came
  ros::Time last_stamp_;
  bool news_ = true;
  bool gap_ = false;  ///< updates were lost: the next whole map mends it
  std::size_t refused_ = 0;
  std::string refusal_;  ///< the last one
};

}  // namespace hymm
