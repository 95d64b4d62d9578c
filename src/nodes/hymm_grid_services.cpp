#include "hybrid_map/geojson_export.h"
#include "hybrid_map/map_export.h"
#include "nodes/hymm_grid_node.h"
#include "perception/scan_check.h"
#include "ros/pose_conversions.h"
#include "ros/sensor_conversions.h"

/// What the node `hymm_grid` answers and tells in /diagnostics.
namespace hymm {
namespace {

/// Callbacks of services that may take a while.
template <class Service, class Node>
ros::ServiceServer advertise(ros::NodeHandle& handle, const std::string& name,
                             bool (Node::*answer)(typename Service::Request&,
                                                  typename Service::Response&),
                             Node* node, ros::CallbackQueue& queue) {
  ros::AdvertiseServiceOptions options = ros::AdvertiseServiceOptions::create<Service>(
      name,
      [answer, node](typename Service::Request& request, typename Service::Response& response) {
        return (node->*answer)(request, response);
      },
      ros::VoidConstPtr(), &queue);
  return handle.advertiseService(options);
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// The covariance of a laser's pose as that of base_link, from which the laser stands at `arm`
/// (map axes).
Eigen::Matrix3d atBase(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& arm) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topRightCorner<2, 1>() << arm.y(), -arm.x();
  return J * covariance * J.transpose();
}

}  // namespace

void HymmGridNode::advertiseServices() {
  services_ = {
      advertise<nav_msgs::GetMap>(handle_, "dynamic_map", &HymmGridNode::getMap, this, calls_),
      advertise<QueryProperty>(handle_, "query_property", &HymmGridNode::queryProperty, this,
                               calls_),
      advertise<ExportMap>(handle_, "export_map", &HymmGridNode::exportMap, this, calls_),
      advertise<MatchScan>(handle_, "match_scan", &HymmGridNode::matchScan, this, calls_),
      advertise<Pause>(private_handle_, "pause", &HymmGridNode::pause, this, calls_),
      advertise<Reset>(private_handle_, "reset", &HymmGridNode::reset, this, calls_),
      advertise<SaveState>(private_handle_, "save_state", &HymmGridNode::saveState, this, calls_),
      advertise<LoadState>(private_handle_, "load_state", &HymmGridNode::loadState, this, calls_)};
}

bool HymmGridNode::getMap(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  response.map = output_.currentMap();
  return true;
}

bool HymmGridNode::queryProperty(QueryProperty::Request& request,
                                 QueryProperty::Response& response) {
  using Status = core::LayerQuery::Status;
  const std::lock_guard<std::mutex> lock(mutex_);
  const core::HybridMap& map = mapper_.map();
  response.landmark_version = map.landmarkVersion();
  response.ltr = core::kNone;
  response.value = response.variance = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector2d place(request.position.x, request.position.y);
  if (!place.allFinite()) {
    response.message = "The position is not finite.";
    return true;
  }
  const core::LayerQuery answer = map.query(request.layer, place);
  if (answer.status == Status::kNoSuchLayer) {
    response.message = "There is no layer '" + request.layer + "'; there are " +
                       listOf(map.layers().names()) + ". Layers are named in hymm_grid's `layers`.";
    return true;
  }
  response.model = map.layers().modelText(map.layers().find(request.layer));
  if (answer.status == Status::kOutside) {
    response.message = "No LTR covers the place: there are too few landmarks around it.";
    return true;
  }
  response.success = true;
  response.ltr = answer.ltr;
  response.known = answer.value.has_value();
  if (answer.value) {
    response.value = answer.value->value;
    response.variance = answer.value->variance;
    response.parts = answer.value->parts;
  } else {
    response.message = "Nothing was measured at the place.";
  }
  return true;
}

bool HymmGridNode::exportMap(ExportMap::Request& request, ExportMap::Response& response) {
  const std::string& format = request.format;
  if (format != "pgm" && format != "octomap" && format != "geojson") {
    response.message = "There is no format '" + format +
                       "'; there are 'pgm' (with yaml), 'octomap' and 'geojson'.";
    return true;
  }
  if (request.path.empty() || request.path.front() != '/') {
    response.message = "The path must be absolute; '" + request.path + "' is not.";
    return true;
  }
  try {
    core::MapImage fresh(config_.image);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      fresh.update(mapper_.map());
      const auto& landmarks = mapper_.landmarks();
      if (format == "geojson") {
        core::exportGeoJson(mapper_.map(), landmarks ? *landmarks : core::LandmarkMap(),
                            fresh.image(), request.path);
      }
    }
    if (format == "pgm") core::exportPgm(fresh.image(), request.path);
    if (format == "octomap") core::exportOctoMap(fresh.image(), request.path);
    response.success = true;
    response.message = "Wrote " + std::to_string(fresh.image().width) + " x " +
                       std::to_string(fresh.image().height) + " cells.";
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

bool HymmGridNode::matchScan(MatchScan::Request& request, MatchScan::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_last = request.scan.ranges.empty();
  response.agreement = std::numeric_limits<double>::quiet_NaN();
  if (is_last && !last_scan_) {
    response.message = "The node has not taken a scan yet; send one along.";
    return true;
  }
  core::LaserScan scan = is_last ? *last_scan_ : fromMessage(request.scan);
  if (const auto problem = core::scanProblem(scan)) {
    response.message = "The scan cannot be used: " + *problem + ".";
    return true;
  }
  core::PoseEstimate pose = last_pose_;
  if (request.use_guess) pose.T_map_base = fromMessage(request.guess);
  if (!is_last) pose.sweep = {};  // how the vehicle moved during another scan is not known
  const core::PosedScan posed = mapper_.posed(scan, pose);
  const core::ScanMatcher& matcher = mapper_.matcher();
  const core::ScanAgreement agreement =
      matcher.agreement(mapper_.map(), posed.scan, posed.T_map_laser);
  const core::ScanMatch match = matcher.match(mapper_.map(), posed.scan, posed.T_map_laser);
  response.agreement = agreement.correlation;
  response.known_beams = static_cast<std::uint32_t>(std::max(0, match.known_beams));
  response.score = match.score;
  response.success = match.matched;
  response.message = match.reason;
  if (!match.matched) return true;
  const core::Pose2 T_map_base = match.T_map_laser * core::inverse(pose.T_base_sensor);
  const Eigen::Vector2d arm = match.T_map_laser.position() - T_map_base.position();
  response.pose = toMessage(T_map_base, atBase(match.covariance, arm));
  return true;
}

bool HymmGridNode::pause(Pause::Request& request, Pause::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  paused_ = request.pause;
  response.success = true;
  response.message =
      paused_ ? "Paused. The map follows the landmarks, but scans are not written." : "Resumed.";
  return true;
}

bool HymmGridNode::reset(Reset::Request&, Reset::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t ltrs = mapper_.topology().size();
  mapper_.reset();
  output_.reset();
  output_.publishLtrs(stamp_);
  response.success = true;
  response.message =
      "Forgot " + std::to_string(ltrs) + " LTRs; the map begins with the next whole landmark map.";
  ROS_INFO_STREAM(response.message);
  return true;
}

void HymmGridNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(mutex_);
  const GridStatus grid = this->status();
  status.summary(DiagnosticStatus::OK, std::to_string(grid.ltrs) + " LTRs");
  status.add("LTRs", grid.ltrs);
  if (paused_) status.mergeSummary(DiagnosticStatus::WARN, "Paused");
  diagnoseScans(grid, status);
  diagnoseMap(grid, status);
  status.add("agreement of scan and map", grid.agreement);
  status.add("latency, worst of the last second [ms]", worst_latency_ms_);
  worst_latency_ms_ = 0.0;
  status.add("CPU [s]", grid.cpu_s);
  for (const auto& [cause, count] : causes_.counts()) status.add(cause, count);
}

/// What became of scans and of what belongs to them.
void HymmGridNode::diagnoseScans(const GridStatus& grid,
                                 diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  if (grid.scans == 0) status.mergeSummary(DiagnosticStatus::WARN, "No scan has been written");
  status.add("scans written", grid.scans);
  status.add("scans not written: pose uncertain among the landmarks", grid.uncertain_scans);
  status.add("scans without landmarks", mapper_.counts().without_landmarks);
  const std::lock_guard<std::mutex> lock(inputs_mutex_);
  const ScanPairing::Counts& pairing = pairing_.counts();
  status.add("scans that the filter refused", pairing.unused_scans);
  status.add("poses without their scan", pairing.missing_scans);
  status.add("landmark maps announced, but missing", pairing.missing_maps);
  status.add("poses or updates alone", pairing.missing_poses);
  status.add("messages dropped (buffers full)", pairing.overflows);
  status.add("dropped scans", pairing.dropped_scans);
  status.add("poses that wait", pairing_.waiting());
  if (pairing.overflows > 0) {
    status.mergeSummary(DiagnosticStatus::WARN, "Messages came faster than they could be used");
  }
}

/// What the map holds, and what it could not.
void HymmGridNode::diagnoseMap(const GridStatus& grid,
                               diagnostic_updater::DiagnosticStatusWrapper& status) const {
  using diagnostic_msgs::DiagnosticStatus;
  const core::HybridMap::Counts& map = mapper_.map().counts();
  status.add("samples written", grid.samples);
  status.add("samples refused", grid.refused_samples);
  status.add("samples that wait for tf", sample_placer_.waiting());
  status.add("LTRs created", map.ltrs_created);
  status.add("LTRs retired", map.ltrs_retired);
  status.add("landmark messages refused", map.refused_landmarks);
  status.add("waiting tiles dropped (waiting/max_memory_mb)", map.dropped_waiting_tiles);
  status.add("LTRs emptied (max_memory_mb)", map.forgotten_ltrs);
  if (map.dropped_waiting_tiles + map.forgotten_ltrs > 0) {
    status.mergeSummary(DiagnosticStatus::WARN, "Observations were dropped for want of memory");
  }
  status.add("cells unpacked [MB]", 1e-6 * static_cast<double>(grid.unpacked_bytes));
  status.add("cells packed [MB]", 1e-6 * static_cast<double>(grid.packed_bytes));
  status.add("cells waiting [MB]", 1e-6 * static_cast<double>(grid.waiting_bytes));
  if (output_.image().isCutOff()) {
    status.mergeSummary(DiagnosticStatus::WARN, "The map's image is cut off (image/max_memory_mb)");
  }
}

}  // namespace hymm
