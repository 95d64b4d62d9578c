#include "nodes/hymm_grid_node.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "ros/filter_conversions.h"
#include "ros/grid_conversions.h"
#include "ros/map_conversions.h"
#include "ros/node_main.h"
#include "ros/sensor_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::uint32_t kUnbounded = 0;  // ScanPairing bounds, and counts what it drops
constexpr auto kPatience = std::chrono::milliseconds(20);
constexpr double kMountingWait_s = 5.0;  // tf_static comes within moments, or not at all
constexpr double kSilence_s = 1.0;       // without scans: time to draw the whole map

}  // namespace

HymmGridNode::HymmGridNode(const core::HymmGridConfig& config, const core::VehicleConfig& vehicle,
                           const core::PointCloudConfig& point_clouds)
    : config_(config),
      vehicle_(vehicle),
      transforms_(tf_, causes_),
      scan_places_(tf_, vehicle.base_frame, std::nullopt, 0.0),
      clouds_(SensorMountings(tf_, vehicle.base_frame, std::nullopt, kMountingWait_s), point_clouds,
              causes_),
      mapper_(config),
      sample_placer_(tf_, vehicle.map_frame, config.sample_wait_s, causes_),
      agreement_(std::numeric_limits<double>::quiet_NaN()),
      output_(handle_, config, vehicle.map_frame, mapper_, mutex_, calls_) {
  if (config.scan_input == "points") {
    subscribe<sensor_msgs::PointCloud2>("points");
  } else {
    subscribe<sensor_msgs::LaserScan>("scan");
  }
  subscribe<FilterPose>("cekf/pose");
  subscribe<LandmarkUpdate>("landmark_updates");
  subscribe<LandmarkMap>("landmarks");
  subscribe<PropertySample>("property_samples");
  traffic_.expect(subscribers_.front().getTopic());
  traffic_.expect(handle_.resolveName("cekf/pose"));
  advertiseServices();
  call_spinner_.start();
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("dense map", this, &HymmGridNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
  step_wall_s_ = steadyNow();
  worker_ = std::thread(&HymmGridNode::work, this);
}

HymmGridNode::~HymmGridNode() {
  call_spinner_.stop();
  working_ = false;
  worker_.join();
}

template <class Message>
void HymmGridNode::subscribe(const std::string& topic) {
  const boost::function<void(const boost::shared_ptr<const Message>&)> take_it =
      [this](const boost::shared_ptr<const Message>& message) { take(message); };
  subscribers_.push_back(traffic_.subscribe<Message>(handle_, topic, kUnbounded, take_it,
                                                     ros::TransportHints().tcpNoDelay()));
}

void HymmGridNode::take(const sensor_msgs::LaserScan::ConstPtr& message) {
  const auto scan = std::make_shared<const HeadedScan>(
      HeadedScan{message->header, message->header.stamp, fromMessage(*message)});
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  pairing_.add(scan);
  arrived_.notify_one();
}

void HymmGridNode::take(const sensor_msgs::PointCloud2::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  clouds_.add(message);
  pairClouds();
  arrived_.notify_one();
}

void HymmGridNode::take(const FilterPose::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  pairing_.add(message, steadyNow());
  arrived_.notify_one();
}

void HymmGridNode::take(const LandmarkUpdate::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  pairing_.add(message);
  arrived_.notify_one();
}

void HymmGridNode::take(const LandmarkMap::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  pairing_.add(message);
  arrived_.notify_one();
}

void HymmGridNode::take(const PropertySample::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  samples_.push_back(message);
  arrived_.notify_one();
}

void HymmGridNode::work() {
  try {
    workOn();
  } catch (const std::exception& error) {
    endAfterFailure(std::string("The dense map cannot go on: ") + error.what());
  }
}

void HymmGridNode::workOn() {
  while (working_) {
    if (isHeld()) {
      std::this_thread::sleep_for(kPatience);
      continue;
    }
    const std::optional<PairedScan> paired = waitForScan();
    disconnectStuckReaders();
    const std::lock_guard<std::mutex> lock(mutex_);
    const double begin_s = steadyNow();
    if (paired) {
      process(*paired);
      worst_latency_ms_ = std::max(worst_latency_ms_, 1e3 * (steadyNow() - begin_s));
    }
    placeSamples();
    publishIfDue();
  }
}

std::optional<PairedScan> HymmGridNode::waitForScan() {
  const bool has_scans = subscribers_.front().getNumPublishers() > 0;
  std::unique_lock<std::mutex> lock(inputs_mutex_);
  std::optional<PairedScan> paired = pairing_.next(steadyNow(), has_scans);
  if (!paired) {
    arrived_.wait_for(lock, kPatience);
    pairClouds();
    paired = pairing_.next(steadyNow(), has_scans);
  }
  return paired;
}

/// Of the clouds whose sensor's place is known, with inputs_mutex_ held.
void HymmGridNode::pairClouds() {
  for (const auto& scan : clouds_.takeReady(steadyNow())) pairing_.add(scan);
}

void HymmGridNode::process(const PairedScan& paired) {
  if (isOfMapBefore(paired)) return;
  core::MappedScan step;
  step.update = fromMessage(*paired.update);
  step.pose.map_version = step.update.version;
  if (paired.map) step.map = std::make_shared<const core::LandmarkMap>(fromMessage(*paired.map));
  bool begins_anew = false;
  if (paired.pose) {
    const core::FilterCourse course = filter_.take(countersOf(*paired.pose));
    begins_anew = course != core::FilterCourse::kGoesOn;
    if (begins_anew) beginAnew(course);
    step.pose = fromMessage(*paired.pose);
    last_pose_ = step.pose;
    stamp_ = paired.pose->header.stamp;
  }
  if (paired.scan) {
    step.scan = paired.scan->scan;
    const bool is_laser = config_.scan_input != "points";  // scans of clouds are upright
    const std::string& frame = paired.scan->header.frame_id;
    if (is_laser && scan_places_.find(frame, 0.0).upside_down) turnUpright(*step.scan);
    last_scan_ = step.scan;
  }
  if (paused_ && step.scan) {
    step.scan.reset();
    causes_.count("scans while paused", "Scans are not written while the node is paused.");
  }
  if (paired.pose && paired.pose->suspended && step.scan) {
    step.scan.reset();
    causes_.count("scans while the filter waits",
                  "Scans are not written while the relocaliser looks for the place.");
  }
  core::MappedOutcome outcome = mapper_.process(step);
  outcome.topology = outcome.topology || begins_anew;
  tell(outcome, paired);
  step_wall_s_ = steadyNow();
  is_settled_ = false;
}

void HymmGridNode::tell(const core::MappedOutcome& outcome, const PairedScan& paired) {
  if (outcome.agreement) agreement_ = outcome.agreement->correlation;
  if (!outcome.follows) {
    causes_.count("landmarks missing", "Scans are not written: " + outcome.reason + ".");
  } else if (!outcome.written && paired.scan && !paused_) {
    causes_.count("scans not written", "A scan is not written: " + outcome.reason + ".");
  }
  if (outcome.topology) output_.publishLtrs(stamp_);
  if (!paired.pose) return;
  const double time_s = stamp_.toSec();
  GridStatus message = status();
  message.for_log = log_due_.takeIfDue(time_s);
  if (status_due_.takeIfDue(time_s) || message.for_log) output_.publishStatus(message, stamp_);
}

void HymmGridNode::beginAnew(core::FilterCourse course) {
  ROS_WARN_STREAM((course == core::FilterCourse::kNewFilter ? "cekf_slam was started anew"
                                                            : "The filter began a new map")
                  << "; the dense map begins anew with it.");
  mapper_.reset();
  sample_placer_.clear();
  tf_.clear();
  agreement_ = std::numeric_limits<double>::quiet_NaN();
  last_scan_.reset();
  output_.reset();
}

void HymmGridNode::placeSamples() {
  const double now_s = steadyNow();
  {
    const std::lock_guard<std::mutex> lock(inputs_mutex_);
    for (const PropertySample::ConstPtr& sample : samples_) sample_placer_.add(sample, now_s);
    samples_.clear();
  }
  for (const core::PropertySample& sample : sample_placer_.takePlaced(now_s)) write(sample);
}

void HymmGridNode::write(const core::PropertySample& sample) {
  const core::MapOutcome outcome = mapper_.insert(sample);
  if (outcome.accepted) return;
  causes_.count("samples refused for layer '" + sample.layer + "'",
                "A property sample is refused: " + outcome.reason + ".");
}

void HymmGridNode::publishIfDue() {
  const double now_s = steadyNow();
  if (!is_settled_ && now_s - step_wall_s_ > kSilence_s) {
    is_settled_ = true;
    output_.publishLtrs(stamp_);
    output_.publishWholeMap(stamp_, now_s);
    output_.publishStatus(status(), stamp_);
    publish_wall_s_ = now_s;
  } else if (now_s - publish_wall_s_ > 1.0 / config_.publish_rate_hz) {
    output_.publishChanges(stamp_, now_s);
    publish_wall_s_ = now_s;
  }
}

void HymmGridNode::disconnectStuckReaders() {
  for (std::size_t times = output_.disconnectStuck(steadyNow()); times > 0; --times) {
    causes_.count("readers disconnected",
                  "A reader of `ltr_grids` or `map_updates` takes nothing although much waits for "
                  "it: the readers of this topic are disconnected, and get the whole map when "
                  "they connect again. Look for a node or a display that hangs.");
  }
}

GridStatus HymmGridNode::status() const {
  GridStatus status;
  const core::HybridMap& map = mapper_.map();
  fillMemory(core::memoryOf(map, stamp_.toSec()), status);
  status.landmark_version = map.landmarkVersion();
  status.scans = map.counts().scans;
  status.uncertain_scans = mapper_.counts().not_written;
  {
    const std::lock_guard<std::mutex> lock(inputs_mutex_);
    const ScanPairing::Counts& pairing = pairing_.counts();
    status.lost_scans =
        mapper_.counts().without_landmarks + pairing.missing_scans + pairing.dropped_scans;
  }
  status.samples = map.counts().samples;
  status.refused_samples = map.counts().refused_samples;
  status.agreement = agreement_;
  status.cpu_s = mapper_.cpu_s() + output_.cpu_s();
  return status;
}

}  // namespace hymm
