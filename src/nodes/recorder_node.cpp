#include "nodes/recorder_node.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "common/error.h"
#include "ros/filter_conversions.h"
#include "ros/map_conversions.h"
#include "ros/pose_conversions.h"
#include "ros/steady_time.h"

namespace hymm {
namespace {

constexpr std::uint32_t kUnbounded = 0;    // a record with holes would be worthless
constexpr double kWriteDelay_s = 2.0;      // by stamps: what comes later than that is out of order
constexpr std::size_t kMostAhead = 10000;  // stamps of what waits for scans that may never come
constexpr std::size_t kMostLate = 1000;    // GPS fixes, a minute of a fast receiver
constexpr double kModeWait_s = 5.0;        // by the wall, for the supervisor's first decision
constexpr double kQuiet_s = 5.0;           // by the wall, after which nothing waits for later scans

/// Leaves what is before the break, in its order.
template <class Message>
std::deque<Message> takeWhatFollows(const RecordingBreak& here, std::deque<Message>& messages) {
  const auto following = std::stable_partition(
      messages.begin(), messages.end(),
      [&](const Message& message) { return here.isBefore(message.header.stamp); });
  std::deque<Message> taken(following, messages.end());
  messages.erase(following, messages.end());
  return taken;
}

}  // namespace

RecorderNode::RecorderNode(const RecorderConfig& config, const core::VehicleConfig& vehicle,
                           int seed)
    : vehicle_(vehicle),
      seed_(static_cast<std::size_t>(seed)),
      output_(config.output),
      writer_(config.output),
      grid_(config.output, causes_),
      level_sets_(config.output),
      gps_(vehicle.gps_antenna.T_base_sensor().position()),
      mode_(FilterStatus::INITIALISING),
      begin_wall_s_(steadyNow()) {
  const auto hints = ros::TransportHints().tcpNoDelay();
  const auto listen = [&](const char* topic, auto callback) {
    subscribers_.push_back(traffic_.subscribe(handle_, topic, kUnbounded, callback, this, hints));
  };
  listen("cekf/pose", &RecorderNode::takePose);
  listen("cekf/health", &RecorderNode::takeHealth);
  listen("pose", &RecorderNode::takePoseInCharge);
  listen("landmarks", &RecorderNode::takeMap);
  listen("landmark_updates", &RecorderNode::takeUpdate);
  listen("gps/fix", &RecorderNode::takeGps);
  listen("filter_status", &RecorderNode::takeStatus);
  traffic_.expect(handle_.resolveName("cekf/pose"));
  grid_.subscribe(handle_);
  level_sets_.subscribe(handle_);
  save_timer_ = handle_.createSteadyTimer(ros::WallDuration(config.save_period_s),
                                          [this](const ros::SteadyTimerEvent&) { save(); });
  diagnostics_.setHardwareID("none");
  diagnostics_.add("inputs", &traffic_, &TrafficMeter::diagnose);
  diagnostics_.add("results", this, &RecorderNode::diagnose);
  diagnostics_timer_ = handle_.createSteadyTimer(
      ros::WallDuration(1.0),
      [this](const ros::SteadyTimerEvent&) { diagnostics_.force_update(); });
}

void RecorderNode::takePose(const FilterPose& message) {
  pairing_.add(message);
  addPairs();
}

void RecorderNode::takeHealth(const FilterHealth& message) {
  pairing_.add(message);
  addPairs();
}

void RecorderNode::takePoseInCharge(const geometry_msgs::PoseWithCovarianceStamped& message) {
  poses_[message.header.stamp.toSec()] = message.pose;
  if (poses_.size() > kMostAhead) poses_.erase(poses_.begin());
}

void RecorderNode::addPairs() {
  const std::size_t unpaired = pairing_.unpaired();
  while (const std::optional<FilterAnswer> answer = pairing_.next()) addScan(*answer);
  if (pairing_.unpaired() > unpaired) {
    causes_.count("pose or health missing", "A pose came without its health, or the other way.");
  }
}

void RecorderNode::addScan(const FilterAnswer& answer) {
  const FilterPose& pose = answer.pose;
  const FilterHealth& health = answer.health;
  if (!last_health_) begin_wall_s_ = steadyNow();
  const double time_s = pose.header.stamp.toSec();
  const core::FilterCourse course = filter_.take(answer.counters());
  landmarks_.hear(pose.map_version);
  if (course != core::FilterCourse::kGoesOn) beginAnew(pose.header.stamp, course);
  last_health_ = health;
  last_scan_wall_s_ = steadyNow();
  scans_.emplace(time_s, core::ScanRecord{fromMessage(pose), fromMessage(health), ""});
  if (!isWaitingForMode()) write(time_s - kWriteDelay_s);
}

void RecorderNode::beginAnew(const ros::Time& stamp, core::FilterCourse course) {
  const RecordingBreak here{last_health_->header.stamp, stamp};
  std::string reason = "the filter was reset";
  if (course == core::FilterCourse::kNewFilter) {
    reason = "cekf_slam was started anew";
    ++restarts_;
  } else if (here.clockRanBack()) {
    reason = "the clock ran back";
  }
  // What has come of the new map already waits for it.
  std::deque<sensor_msgs::NavSatFix> fixes = std::move(late_fixes_);
  for (const auto& [time_s, fix] : fixes_) fixes.push_back(fix);
  late_fixes_.clear();
  fixes_.clear();
  const std::deque<sensor_msgs::NavSatFix> new_fixes = takeWhatFollows(here, fixes);
  const std::deque<FilterStatus> new_statuses = takeWhatFollows(here, statuses_);
  wait(fixes);
  write(std::numeric_limits<double>::infinity());
  for (const FilterStatus& status : statuses_) switchMode(status);
  statuses_ = new_statuses;
  poses_.clear();
  writer_.addReset(stamp.toSec(), reason + "; a new map begins");
  gps_.reset();
  wait(new_fixes);
}

void RecorderNode::wait(const std::deque<sensor_msgs::NavSatFix>& fixes) {
  for (const sensor_msgs::NavSatFix& fix : fixes) fixes_.emplace(fix.header.stamp.toSec(), fix);
}

void RecorderNode::write(double up_to_s) {
  while (true) {
    const bool fix_is_next =
        !fixes_.empty() && (scans_.empty() || fixes_.begin()->first <= scans_.begin()->first);
    if (fix_is_next && fixes_.begin()->first <= up_to_s) {
      writeFix(fixes_.begin()->second);
      fixes_.erase(fixes_.begin());
    } else if (!fix_is_next && !scans_.empty() && scans_.begin()->first <= up_to_s) {
      writeScan(scans_.begin()->second);
      scans_.erase(scans_.begin());
    } else {
      return;
    }
  }
}

/// The supervisor decides a little after the scan; its decision bears the scan's stamp.
void RecorderNode::writeScan(core::ScanRecord scan) {
  while (!statuses_.empty() && statuses_.front().header.stamp.toSec() <= scan.pose.time_s) {
    switchMode(statuses_.front());
    statuses_.pop_front();
  }
  scan.mode = mode_;
  const auto in_charge = poses_.find(scan.pose.time_s);
  if (in_charge != poses_.end()) {
    scan.pose.T_map_base = fromMessage(in_charge->second.pose);
    scan.pose.covariance = planarCovariance(in_charge->second);
    poses_.erase(poses_.begin(), std::next(in_charge));
  }
  ++written_scans_;
  try {
    writer_.addScan(scan);
  } catch (const core::OutputError& error) {  // it waits for the next attempt
    tellNotSaved(error);
  }
}

void RecorderNode::switchMode(const FilterStatus& status) {
  mode_ = status.mode;
  writer_.addModeSwitch(status.header.stamp.toSec(), mode_, status.reason);
}

/// Converted no earlier: only now it is certain to which map, and so to which origin, it belongs.
void RecorderNode::writeFix(const sensor_msgs::NavSatFix& message) {
  const GpsConverter::Answer answer = gps_.convert(message);
  if (answer.fix) {
    writer_.addGps(*answer.fix);
  } else {
    causes_.count("GPS fix refused", "A GPS fix is not recorded: " + answer.problem + ".");
  }
}

void RecorderNode::writeLateFixes() {
  for (const sensor_msgs::NavSatFix& fix : late_fixes_) writeFix(fix);
  late_fixes_.clear();
}

bool RecorderNode::isWaitingForMode() const {
  return mode_ == FilterStatus::INITIALISING && steadyNow() - begin_wall_s_ < kModeWait_s;
}

void RecorderNode::takeMap(const LandmarkMap& message) { landmarks_.take(fromMessage(message)); }

void RecorderNode::takeUpdate(const LandmarkUpdate& message) {
  if (!landmarks_.take(fromMessage(message))) {
    causes_.count("map incomplete", "Changes of the map are missing; waiting for the whole map.");
  }
}

void RecorderNode::takeGps(const sensor_msgs::NavSatFix& message) {
  const double time_s = message.header.stamp.toSec();
  if (last_health_ && time_s < last_health_->header.stamp.toSec() - kWriteDelay_s) {
    // Out of order, or the first of another recording, of which no scan has come yet.
    late_fixes_.push_back(message);
    if (late_fixes_.size() > kMostLate) writeLateFixes();
    return;
  }
  fixes_.emplace(time_s, message);
  if (fixes_.size() <= kMostAhead) return;
  fixes_.erase(std::prev(fixes_.end()));
  causes_.count("GPS fixes ahead of scans",
                "GPS fixes are stamped later than all scans; they are not recorded.");
}

void RecorderNode::takeStatus(const FilterStatus& message) {
  if (message.mode == FilterStatus::INITIALISING) return;
  if (mode_ == FilterStatus::INITIALISING) mode_ = message.mode;  // the first one is no switch
  const std::string& newest = statuses_.empty() ? mode_ : statuses_.back().mode;
  if (message.mode != newest) statuses_.push_back(message);
}

core::RunTotals RecorderNode::totals() const {
  core::RunTotals totals;
  // To the last scan: a playback that is kept on the screen has long ended.
  totals.wall_s = (scans_.empty() && isQuiet() ? last_scan_wall_s_ : steadyNow()) - begin_wall_s_;
  totals.seed = seed_;
  totals.gps_antenna_m = vehicle_.gps_antenna.T_base_sensor().position();
  totals.notes = {
      "Recorded live: peak_rss_mb is that of the node cekf_slam, cpu_s that node's and the dense "
      "map's."};
  if (restarts_ > 0) {
    totals.notes.push_back("cekf_slam was started anew " + std::to_string(restarts_) +
                           " time(s): its counts, cpu_s and peak_rss_mb are those since the last.");
  }
  if (!last_health_) return totals;
  totals.cpu_s = last_health_->process_cpu_s;
  totals.peak_rss_mb = last_health_->peak_rss_mb;
  totals.subsystem_cpu_s = {{"perception", last_health_->perception_cpu_s},
                            {"filter", last_health_->filter_cpu_s},
                            {"worker", last_health_->worker_cpu_s}};
  grid_.addTo(totals);
  totals.addOtherCpu();
  totals.dropped_scans =
      static_cast<std::size_t>(last_health_->dropped_scans + last_health_->refused_scans);
  totals.observations = static_cast<std::size_t>(last_health_->observations);
  totals.associated = static_cast<std::size_t>(last_health_->associated);
  totals.rejected = static_cast<std::size_t>(last_health_->rejected);
  totals.map_corrections = static_cast<std::size_t>(last_health_->map_corrections);
  totals.global_updates = static_cast<std::size_t>(last_health_->global_updates);
  totals.deferred_global_updates = static_cast<std::size_t>(last_health_->deferred_global_updates);
  totals.global_update_waits = static_cast<std::size_t>(last_health_->global_update_waits);
  return totals;
}

bool RecorderNode::isQuiet() const {
  return last_health_ && steadyNow() - last_scan_wall_s_ > kQuiet_s;
}

void RecorderNode::save() {
  const double begin_s = steadyNow();
  if (isQuiet()) write(std::numeric_limits<double>::infinity());
  if (written_scans_ == 0) return;  // the results of an earlier run stay until then
  try {
    grid_.write();
    level_sets_.write();
    writer_.save(landmarks_.map(), totals());
    saved_wall_s_ = steadyNow();
    save_ms_ = 1e3 * (saved_wall_s_ - begin_s);
    is_saved_ = true;
  } catch (const core::OutputError& error) {  // perhaps there will be room again next time
    tellNotSaved(error);
  }
}

void RecorderNode::tellNotSaved(const core::OutputError& error) {
  is_saved_ = false;
  causes_.count("not saved", std::string("Results cannot be saved: ") + error.what());
}

void RecorderNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "Recording");
  if (!last_health_) status.summary(DiagnosticStatus::WARN, "No scan has been recorded");
  status.add("scans written", written_scans_);
  status.add("scans that wait for later ones", scans_.size());
  status.add("poses or healths without the other", pairing_.unpaired());
  status.add("GPS fixes that wait for later ones", fixes_.size());
  if (saved_wall_s_ > 0.0) {
    status.add("age of the folder [s, wall]", steadyNow() - saved_wall_s_);
    status.add("saving, last [ms]", save_ms_);
  }
  const auto causes = causes_.counts();
  for (const auto& [cause, count] : causes) status.add(cause, count);
  if (!is_saved_) status.mergeSummary(DiagnosticStatus::ERROR, "Results could not be saved");
}

void RecorderNode::finish() {
  save_timer_.stop();
  diagnostics_timer_.stop();
  write(std::numeric_limits<double>::infinity());
  if (written_scans_ == 0) {
    ROS_WARN_STREAM("No scan has come; nothing is recorded, and " << output_
                                                                  << " is left as it was.");
    return;
  }
  writeLateFixes();
  grid_.write();
  level_sets_.write();
  writer_.finish(landmarks_.map(), totals());
}

}  // namespace hymm
