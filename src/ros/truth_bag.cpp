#include "ros/truth_bag.h"

#include <geometry_msgs/PoseStamped.h>
#include <hymm/LandmarkMap.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include "ros/bag_errors.h"
#include "ros/pose_conversions.h"

namespace hymm {

Truth readTruth(const std::string& path) {
  return withBagErrors(path, [&] {
    Truth truth;
    rosbag::Bag bag;
    openBag(bag, path);
    rosbag::View poses(bag, rosbag::TopicQuery("/truth/pose"));
    for (const rosbag::MessageInstance& instance : poses) {
      const auto message = instance.instantiate<geometry_msgs::PoseStamped>();
      if (message)
        truth.poses.push_back({message->header.stamp.toSec(), fromMessage(message->pose)});
    }
    rosbag::View maps(bag, rosbag::TopicQuery("/truth/landmarks"));
    for (const rosbag::MessageInstance& instance : maps) {
      const auto message = instance.instantiate<LandmarkMap>();
      if (!message) continue;
      truth.landmarks.clear();
      for (const auto& landmark : message->landmarks) {
        truth.landmarks.emplace_back(landmark.position.x, landmark.position.y);
      }
    }
    return truth;
  });
}

}  // namespace hymm
