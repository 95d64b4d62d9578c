#include "ros/grid_output.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <ros/single_subscriber_publisher.h>

#include "common/cpu_timer.h"
#include "ros/grid_conversions.h"

namespace hymm {
namespace {

constexpr std::uint32_t kMapQueue = 2;  // a newer one takes its place
constexpr bool kLatched = true;

/// Of a publisher that serves new subscribers by `serve`, out of `queue`.
template <class Message>
ros::AdvertiseOptions serving(const std::string& topic, ros::CallbackQueue& queue,
                              const ros::SubscriberStatusCallback& serve) {
  return ros::AdvertiseOptions::create<Message>(
      topic, kMapQueue, serve, ros::SubscriberStatusCallback(), ros::VoidConstPtr(), &queue);
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
  map_updates_ = BoundedPublisher(
      handle_, serving<map_msgs::OccupancyGridUpdate>("map_updates", queue, {}), {});
  grids_ =
      BoundedPublisher(handle_,
                       serving<LtrGrid>("ltr_grids", queue,
                                        [this](const auto& subscriber) { serveGrids(subscriber); }),
                       {});
  ros::AdvertiseOptions map = serving<nav_msgs::OccupancyGrid>(
      "map", queue, [this](const auto& subscriber) { serveMap(subscriber); });
  map.latch = kLatched;
  map_ = handle_.advertise(map);
}

std::size_t GridOutput::disconnectStuck(double steady_now_s) {
  std::size_t times = 0;
  if (grids_.disconnectIfStuck(steady_now_s)) ++times;
  if (map_updates_.disconnectIfStuck(steady_now_s)) {
    ++times;
    const std::lock_guard<std::mutex> lock(mutex_);
    map_is_sent_ = false;  // what readers miss until they are back, the whole map tells
    map_sent_s_ = steady_now_s;
  }
  return times;
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
  publishGrids();
  if (!map_updates_.isFull()) publishImage(steady_now_s);
}

/// In the order in which they changed, so that it can go on where it stopped.
void GridOutput::publishGrids() {
  const core::HybridMap& map = mapper_.map();
  if (grids_.getNumSubscribers() > 0) {
    std::vector<core::ChangedLayer> layers = map.changedSince(sent_revision_);
    std::sort(layers.begin(), layers.end(),
              [](const auto& a, const auto& b) { return a.revision < b.revision; });
    for (const core::ChangedLayer& layer : layers) {
      if (layer.revision > sent_revision_ && grids_.isFull()) return;
      grids_.publish(stamped(toMessage(map, layer)));
      sent_revision_ = layer.revision;
    }
  }
  sent_revision_ = map.revision();
}

void GridOutput::publishImage(double steady_now_s) {
  const core::ImageChange change = image_.update(mapper_.map());
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
