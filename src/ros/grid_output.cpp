#include "ros/grid_output.h"

#include <utility>

#include <ros/single_subscriber_publisher.h>

#include "common/cpu_timer.h"
#include "ros/grid_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kGridQueue = 10000;  // a planner wants each LTR, however late it reads
constexpr bool kLatched = true;

/// A publisher that serves new subscribers by `serve`, out of `queue`.
template <class Message>
ros::Publisher advertise(ros::NodeHandle& handle, const std::string& topic, std::uint32_t size,
                         bool latched, ros::CallbackQueue& queue,
                         const ros::SubscriberStatusCallback& serve) {
  ros::AdvertiseOptions options = ros::AdvertiseOptions::create<Message>(
      topic, size, serve, ros::SubscriberStatusCallback(), ros::VoidConstPtr(), &queue);
  options.latch = latched;
  return handle.advertise(options);
}

}  // namespace

GridOutput::GridOutput(ros::NodeHandle handle, const core::HymmGridConfig& config,
                       std::string map_frame, const core::GridMapper& mapper, std::mutex& mutex,
                       ros::CallbackQueue& queue)
    : handle_(std::move(handle)),
      config_(config),
      map_frame_(std::move(map_frame)),
      mapper_(mapper),
      mutex_(mutex),
      image_(config.image) {
  ltrs_ = handle_.advertise<LtrMap>("ltrs", 10, kLatched);
  status_ = handle_.advertise<GridStatus>("grid_status", 1000, kLatched);
  metadata_ = handle_.advertise<nav_msgs::MapMetaData>("map_metadata", 10, kLatched);
  map_updates_ = handle_.advertise<map_msgs::OccupancyGridUpdate>("map_updates", 1000);
  grids_ = advertise<LtrGrid>(handle_, "ltr_grids", kGridQueue, false, queue,
                              [this](const auto& subscriber) { serveGrids(subscriber); });
  map_ =
      advertise<nav_msgs::OccupancyGrid>(handle_, "map", 10, kLatched, queue,
                                         [this](const auto& subscriber) { serveMap(subscriber); });
}

template <class Message>
Message GridOutput::stamped(Message message) const {
  message.header.stamp = stamp_;
  message.header.frame_id = map_frame_;
  return message;
}

void GridOutput::publishLtrs(const ros::Time& stamp) {
  const core::CpuTimer timer(cpu_s_);
  stamp_ = stamp;
  ltrs_.publish(stamped(toMessage(mapper_.topology(), mapper_.map().landmarkVersion())));
}

void GridOutput::publishChanges(const ros::Time& stamp, double steady_now_s) {
  const core::CpuTimer timer(cpu_s_);
  stamp_ = stamp;
  const core::HybridMap& map = mapper_.map();
  if (grids_.getNumSubscribers() > 0) {
    for (const core::ChangedLayer& changed : map.changedSince(sent_revision_)) {
      grids_.publish(stamped(toMessage(map, changed)));
    }
  }
  sent_revision_ = map.revision();

  const core::ImageChange change = image_.update(map);
  if (change.is_resized) {
    sendMap(steady_now_s);
    return;
  }
  if (!change.isEmpty()) map_is_sent_ = false;
  for (const core::ImagePatch& patch : change.patches) {
    map_updates_.publish(stamped(toMessage(image_.image(), patch)));
  }
  const bool is_due = steady_now_s >= map_sent_s_ + config_.whole_map_period_s;
  if (is_due && !map_is_sent_) sendMap(steady_now_s);
}

void GridOutput::publishWholeMap(const ros::Time& stamp, double steady_now_s) {
  publishChanges(stamp, steady_now_s);
  const core::CpuTimer timer(cpu_s_);
  image_ = core::MapImage(config_.image);
  image_.update(mapper_.map());
  sendMap(steady_now_s);
}

void GridOutput::sendMap(double steady_now_s) {
  map_sent_s_ = steady_now_s;
  map_is_sent_ = true;
  const nav_msgs::OccupancyGrid map = mapMessage();
  map_.publish(map);
  metadata_.publish(map.info);
}

nav_msgs::OccupancyGrid GridOutput::mapMessage() const {
  nav_msgs::OccupancyGrid map = stamped(toMessage(image_.image()));
  map.info.map_load_time = stamp_;
  return map;
}

nav_msgs::OccupancyGrid GridOutput::currentMap() {
  image_.update(mapper_.map());
  map_is_sent_ = false;  // the change goes out with the next whole map
  map_sent_s_ = 0.0;
  return mapMessage();
}

void GridOutput::publishStatus(GridStatus status, const ros::Time& stamp) {
  status.header.stamp = stamp;
  status.header.frame_id = map_frame_;
  status_.publish(status);
}

void GridOutput::reset() {
  image_ = core::MapImage(config_.image);
  sent_revision_ = mapper_.map().revision();
  map_sent_s_ = 0.0;
}

void GridOutput::resetToLoaded() {
  reset();
  sent_revision_ = 0;
}

void GridOutput::serveGrids(const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const core::ChangedLayer& layer : mapper_.map().changedSince(0)) {
    subscriber.publish(stamped(toMessage(mapper_.map(), layer)));
  }
}

void GridOutput::serveMap(const ros::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!map_is_sent_ && !image_.image().cells.empty()) subscriber.publish(mapMessage());
}

}  // namespace hymm
