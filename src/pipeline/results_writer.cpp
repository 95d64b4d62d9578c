#include "pipeline/results_writer.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/error.h"
#include "common/json.h"
#include "common/unfinished_file.h"
#include "pipeline/csv_line.h"
#include "pipeline/results_folder.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostWaitingBytes = 1 << 20;

std::string typeName(LandmarkType type) {
  switch (type) {
    case LandmarkType::kTrunk:
      return "trunk";
    case LandmarkType::kReflector:
      return "reflector";
    case LandmarkType::kUnknown:
      break;
  }
  return "unknown";
}

/// CPU of the worker behind the filter for each scan; nothing where that is not known.
std::optional<double> workerMilliseconds(const RunTotals& totals, std::size_t scans) {
  const auto worker = totals.subsystem_cpu_s.find("worker");
  if (worker == totals.subsystem_cpu_s.end() || scans == 0) return std::nullopt;
  return 1e3 * worker->second / static_cast<double>(scans);
}

JsonObject latencyJson(const LatencyHistogram& latency) {
  JsonObject json;
  json.add("p50", latency.quantile(0.5)).add("p95", latency.quantile(0.95));
  json.add("p99", latency.quantile(0.99)).add("p999", latency.quantile(0.999));
  json.add("max", latency.max());
  return json;
}

std::string landmarksText(const LandmarkMap& map) {
  std::string text = "id,type,x,y,cxx,cxy,cyy,diameter,observations\n";
  for (const LandmarkEstimate& landmark : map.landmarks) {
    const Eigen::Matrix2d& C = landmark.covariance;
    text += csvLine(',', landmark.id, typeName(landmark.type), landmark.position.x(),
                    landmark.position.y(), C(0, 0), C(0, 1), C(1, 1), landmark.diameter_m,
                    landmark.observations);
    text += '\n';
  }
  return text;
}

}  // namespace

void RunTotals::addOtherCpu() {
  double other_s = cpu_s;
  for (const auto& subsystem : subsystem_cpu_s) other_s -= subsystem.second;
  subsystem_cpu_s["other"] = std::max(0.0, other_s);
}

ResultsWriter::ResultsWriter(const std::string& folder)
    : folder_(makeResultsFolder(folder)),
      trajectory_(folder_ / "trajectory.tum"),
      covariance_(folder_ / "pose_covariance.csv"),
      health_(folder_ / "health.csv"),
      gps_(folder_ / "gps.csv"),
      events_(folder_ / "events.csv") {
  covariance_.add("t,xx,xy,xyaw,yy,yyaw,yawyaw");
  health_.add("t,nis,dof,ambiguity,unexplained,missed,latency_ms,mode");
  gps_.add("t,x,y,cxx,cxy,cyy");
  events_.add("t,scan,event,mode,reason");
}

void ResultsWriter::addScan(const ScanRecord& record) {
  const double t = record.pose.time_s;
  const Pose2& pose = record.pose.T_map_base;
  const Eigen::Matrix3d& P = record.pose.covariance;
  const FilterHealth& health = record.health;
  trajectory_.add(csvLine(' ', t, pose.x_m, pose.y_m, 0, 0, 0, std::sin(pose.yaw_rad / 2.0),
                          std::cos(pose.yaw_rad / 2.0)));
  covariance_.add(csvLine(',', t, P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2)));
  health_.add(csvLine(',', t, health.nis, health.dof, health.ambiguity, health.unexplained,
                      health.missed, health.latency_ms, record.mode));
  mode_ = record.mode;
  ++scans_;
  if (!first_s_) first_s_ = t;
  last_s_ = t;
  nis_ += health.nis;
  dof_ += health.dof;
  latency_.add(health.latency_ms);
  gps_alignment_.addPose({t, pose});
  flushIfMuchWaits();
}

void ResultsWriter::addGps(const GpsFix& fix) {
  const Eigen::Matrix2d& C = fix.covariance;
  gps_.add(csvLine(',', fix.time_s, fix.position.x(), fix.position.y(), C(0, 0), C(0, 1), C(1, 1)));
  ++gps_fixes_;
  gps_alignment_.addFix(fix);
}

void ResultsWriter::addModeSwitch(double time_s, const std::string& mode,
                                  const std::string& reason) {
  mode_ = mode;
  ++mode_switches_;
  addEvent(time_s, "mode_switch", reason);
}

void ResultsWriter::addReset(double time_s, const std::string& reason) {
  ++resets_;
  addEvent(time_s, "reset", reason);
  gps_alignment_.startMap();
  if (first_s_) duration_s_ += *last_s_ - *first_s_;
  first_s_.reset();
  last_s_.reset();
}

void ResultsWriter::addEvent(double time_s, const char* event, const std::string& reason) {
  events_.add(csvLine(',', time_s, scans_, std::string(event), mode_, reason));
}

void ResultsWriter::save(const LandmarkMap& map, const RunTotals& totals) {
  RunTotals so_far = totals;
  so_far.notes.emplace_back("Saved while the run went on; it had not ended.");
  finish(map, so_far);
}

void ResultsWriter::finish(const LandmarkMap& map, const RunTotals& totals) {
  flushLines();
  replaceFile(folder_ / "landmarks.csv", landmarksText(map));
  replaceFile(folder_ / "summary.json", summaryText(map, totals));
}

std::vector<LineFile*> ResultsWriter::files() {
  return {&trajectory_, &covariance_, &health_, &gps_, &events_};
}

void ResultsWriter::flushIfMuchWaits() {
  std::size_t waiting = 0;
  for (const LineFile* file : files()) waiting += file->waiting();
  if (waiting <= next_flush_bytes_) return;
  // Where it fails, the next attempt is not with the next scan: each hands over all that waits.
  next_flush_bytes_ = waiting + kMostWaitingBytes;
  flushLines();
}

void ResultsWriter::flushLines() {
  if (!is_begun_) removeResults(folder_);
  is_begun_ = true;
  LineFile::flushTogether(files());
  next_flush_bytes_ = kMostWaitingBytes;
}

std::string ResultsWriter::summaryText(const LandmarkMap& map, const RunTotals& totals) const {
  const double duration_s = duration_s_ + (first_s_ ? *last_s_ - *first_s_ : 0.0);
  JsonObject cpu;
  for (const auto& [subsystem, seconds] : totals.subsystem_cpu_s) cpu.add(subsystem, seconds);
  JsonObject json;
  json.add("scans", scans_).add("duration_s", duration_s);
  json.add("wall_s", totals.wall_s).add("cpu_s", totals.cpu_s);
  json.add("real_time_factor", duration_s / totals.wall_s);
  json.add("peak_rss_mb", totals.peak_rss_mb);
  json.add("landmarks", map.landmarks.size()).add("ltrs", totals.ltrs);
  json.add("observations", totals.observations).add("associated", totals.associated);
  json.add("rejected", totals.rejected);
  json.add("scan_latency_ms", latencyJson(latency_)).add("subsystem_cpu_s", cpu);
  json.add("worker_ms", workerMilliseconds(totals, scans_));
  json.add("global_updates", totals.global_updates);
  json.add("deferred_global_updates", totals.deferred_global_updates);
  json.add("global_update_waits", totals.global_update_waits);
  json.add("nis_mean", dof_ > 0 ? std::optional(nis_ / static_cast<double>(dof_)) : std::nullopt);
  json.add("gps_rmse_m", gps_alignment_.rmse());
  json.add("map_corrections", totals.map_corrections).add("mode_switches", mode_switches_);
  json.add("dropped_scans", totals.dropped_scans);
  json.add("resets", resets_).add("gps_fixes", gps_fixes_);
  json.add("gps_fixes_compared", gps_alignment_.count());
  if (totals.gps_antenna_m) {
    json.add("gps_antenna_m", std::vector{totals.gps_antenna_m->x(), totals.gps_antenna_m->y()});
  } else {
    json.addNull("gps_antenna_m");
  }
  json.add("seed", totals.seed).add("notes", totals.notes);
  return json.text() + '\n';
}

}  // namespace hymm::core
