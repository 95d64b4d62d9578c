#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include <hymm/GridStatus.h>
#include <hymm/LtrMap.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>

#include "hybrid_map/map_image.h"
#include "pipeline/grid_mapper.h"
#include "ros/bounded_publisher.h"

namespace hymm {

/// Publishes the dense map: `ltrs`, `ltr_grids`, `map`, `map_updates`, `map_metadata` and
/// `grid_status`. Only what changed is sent; a new subscriber of `ltr_grids` or `map` gets all of
/// it. What changed waits here, and later changes with it, while a reader has too much to take.
class GridOutput {
 public:
  /// New subscribers are served by the callbacks of `queue`, which hold `mutex` while they read
  /// `mapper`; both, and the mapper, outlive the object. Throws ConfigError.
  GridOutput(ros::NodeHandle handle, const core::HymmGridConfig& config, std::string map_frame,
             const core::GridMapper& mapper, std::mutex& mutex, ros::CallbackQueue& queue);

  /// Disconnects the readers of `ltr_grids` or `map_updates` where one has hung for long; how often
  /// it did so. By the thread that publishes changes, without the mutex.
  std::size_t disconnectStuck(double steady_now_s);

  // All of these with the mutex held.

  /// The topology, after a scan.
  void publishLtrs(const ros::Time& stamp);
  /// What was written or moved since the last call.
  void publishChanges(const ros::Time& stamp, double steady_now_s);
  /// The whole map, drawn anew, so that it shows the last of every small movement.
  void publishWholeMap(const ros::Time& stamp, double steady_now_s);
  void publishStatus(GridStatus status, const ros::Time& stamp);
  /// An empty map, at another recording.
  void reset();
  /// A map that was loaded: all of it has changed.
  void resetToLoaded();

  /// The map as it is now.
  nav_msgs::OccupancyGrid currentMap();

  const core::MapImage& image() const { return image_; }
  double cpu_s() const { return cpu_s_; }

 private:
  void publishGrids();
  void publishImage(double steady_now_s);
  void serveGrids(const ros::SingleSubscriberPublisher& subscriber);
  void serveMap(const ros::SingleSubscriberPublisher& subscriber);
  void sendMap(double steady_now_s);
  nav_msgs::OccupancyGrid mapMessage() const;
  template <class Message>
  Message stamped(Message message) const;

  ros::NodeHandle handle_;
  core::HymmGridConfig config_;
  std::string map_frame_;
  const core::GridMapper& mapper_;
  std::mutex& mutex_;
  core::MapImage image_;
  ros::Time stamp_;                  ///< of what was published last
  std::uint64_t sent_revision_ = 0;  ///< of the map, up to which grids were sent
  double map_sent_s_ = 0.0;
  bool map_is_sent_ = false;  ///< the whole one, and nothing changed since
  double cpu_s_ = 0.0;
  ros::Publisher ltrs_, map_, metadata_, status_;
  BoundedPublisher grids_, map_updates_;
};

}  // namespace hymm
