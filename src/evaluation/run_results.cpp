#include "evaluation/run_results.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "common/error.h"
#include "evaluation/csv_table.h"

namespace hymm::core {
namespace {

std::string in(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

/// Scans written before the last reset, and how many resets there were.
struct Resets {
  std::size_t count = 0;
  std::size_t first_scan = 0;
};

Resets readResets(const std::string& file) {
  const CsvTable events(file);
  const std::vector<std::string> kinds = events.texts("event");
  const std::vector<double> scans = events.numbers("scan");
  Resets resets;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i] != "reset") continue;
    ++resets.count;
    resets.first_scan = static_cast<std::size_t>(scans[i]);
  }
  return resets;
}

/// Poses of the scans from `first` to `end`: lines beyond came after the summary of a run that did
/// not end.
std::vector<UncertainPose> readPoses(const std::string& folder, std::size_t first,
                                     std::size_t end) {
  const std::string file = in(folder, "trajectory.tum");
  const auto rows = readNumberRows(file, 8);
  const CsvTable table(in(folder, "pose_covariance.csv"));
  if (table.rows() < end || rows.size() < end) {
    throw InputError(file + ": has " + std::to_string(rows.size()) +
                     " poses and pose_covariance.csv " + std::to_string(table.rows()) +
                     ", but summary.json tells of " + std::to_string(end) +
                     "; are the files of one run?");
  }
  const auto xx = table.numbers("xx"), xy = table.numbers("xy"), xyaw = table.numbers("xyaw");
  const auto yy = table.numbers("yy"), yyaw = table.numbers("yyaw");
  const auto yawyaw = table.numbers("yawyaw");
  std::vector<UncertainPose> poses;
  for (std::size_t i = first; i < end; ++i) {
    const auto& row = rows[i];
    UncertainPose pose;
    pose.pose = {row[0], {row[1], row[2], 2.0 * std::atan2(row[6], row[7])}};
    pose.pose.pose.yaw_rad = wrapAngle(pose.pose.pose.yaw_rad);
    pose.covariance << xx[i], xy[i], xyaw[i], xy[i], yy[i], yyaw[i], xyaw[i], yyaw[i], yawyaw[i];
    poses.push_back(pose);
  }
  return poses;
}

std::vector<StampedNis> readNis(const std::string& file, std::size_t first, std::size_t end) {
  const CsvTable table(file);
  const auto t = table.numbers("t"), nis = table.numbers("nis"), dof = table.numbers("dof");
  std::vector<StampedNis> values;
  for (std::size_t i = first; i < std::min(end, t.size()); ++i) {
    values.push_back({t[i], nis[i], static_cast<int>(dof[i])});
  }
  return values;
}

std::vector<LandmarkEstimate> readLandmarks(const std::string& file) {
  const CsvTable table(file);
  const auto id = table.numbers("id"), x = table.numbers("x"), y = table.numbers("y");
  const auto cxx = table.numbers("cxx"), cxy = table.numbers("cxy"), cyy = table.numbers("cyy");
  std::vector<LandmarkEstimate> landmarks(id.size());
  for (std::size_t i = 0; i < id.size(); ++i) {
    landmarks[i].id = static_cast<int>(id[i]);
    landmarks[i].position = {x[i], y[i]};
    landmarks[i].covariance << cxx[i], cxy[i], cxy[i], cyy[i];
  }
  return landmarks;
}

std::vector<StampedPosition> readPositions(const CsvTable& table) {
  const auto t = table.numbers("t"), x = table.numbers("x"), y = table.numbers("y");
  std::vector<StampedPosition> positions;
  for (std::size_t i = 0; i < t.size(); ++i) positions.push_back({t[i], {x[i], y[i]}});
  return positions;
}

/// Fixes of the last recording: those after the last step back of their own clock.
std::vector<StampedPosition> readLastGps(const std::string& file) {
  std::vector<StampedPosition> fixes = readPositions(CsvTable(file));
  std::size_t first = 0;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    if (fixes[i].time_s < fixes[i - 1].time_s) first = i;
  }
  fixes.erase(fixes.begin(), fixes.begin() + static_cast<std::ptrdiff_t>(first));
  return fixes;
}

struct Summary {
  std::size_t scans = 0;
  std::optional<Eigen::Vector2d> gps_antenna;
};

/// JSON is YAML.
Summary readSummary(const std::string& file) {
  try {
    const YAML::Node json = YAML::LoadFile(file);
    Summary summary;
    summary.scans = json["scans"].as<std::size_t>();
    const YAML::Node antenna = json["gps_antenna_m"];
    if (antenna && antenna.IsSequence() && antenna.size() == 2) {
      summary.gps_antenna = Eigen::Vector2d(antenna[0].as<double>(), antenna[1].as<double>());
    }
    return summary;
  } catch (const YAML::Exception& error) {
    throw InputError(file + ": " + error.what() + "; did the run end?");
  }
}

}  // namespace

RunResults readRunResults(const std::string& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(folder + ": is not a folder of results.");
  }
  const Resets resets = readResets(in(folder, "events.csv"));
  const Summary summary = readSummary(in(folder, "summary.json"));
  RunResults results;
  results.resets = resets.count;
  results.poses = readPoses(folder, resets.first_scan, summary.scans);
  results.nis = readNis(in(folder, "health.csv"), resets.first_scan, summary.scans);
  results.landmarks = readLandmarks(in(folder, "landmarks.csv"));
  results.gps = readLastGps(in(folder, "gps.csv"));
  results.gps_antenna = summary.gps_antenna;
  return results;
}

std::vector<StampedPosition> readFixes(const std::string& file) {
  if (hasHeader(file)) return readPositions(CsvTable(file));
  std::vector<StampedPosition> fixes;
  for (const auto& row : readNumberRows(file, 3)) fixes.push_back({row[0], {row[2], row[1]}});
  return fixes;
}

std::vector<Eigen::Vector2d> readSurvey(const std::string& file) {
  const CsvTable table(file);
  const auto x = table.numbers("x"), y = table.numbers("y");
  std::vector<Eigen::Vector2d> positions;
  for (std::size_t i = 0; i < x.size(); ++i) positions.emplace_back(x[i], y[i]);
  return positions;
}

}  // namespace hymm::core
