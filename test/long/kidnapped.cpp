// Victoria Park: drives all of the recording, then throws the pose away at ten moments and looks
// for the vehicle in the finished map. One line of CSV for each moment.
// scripts/experiments/kidnapped makes figures of it.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "cekf/cekf_slam.h"
#include "datasets/acfr_recording.h"
#include "pipeline/suite_config.h"
#include "relocaliser/neighbourhoods.h"
#include "relocaliser/place_search.h"

namespace hymm {
namespace {

constexpr int kMoments = 10;
constexpr double kLongest_s = 120.0;  // of an attempt
constexpr int kFewestForReference = 3;

/// What a scan showed, and of which landmarks.
struct Scan {
  core::ObservationSet set;
  std::vector<core::Association> associations;
  core::Pose2 online;  ///< as estimated then, before later loops moved the map
};

struct Drive {
  std::vector<core::MotionInput> motion;
  std::vector<Scan> scans;
  core::Calibration calibration;
  core::LandmarkMap map;
  core::JointLandmarks joint;
};

Drive driveAll(const core::AcfrRecording& recording, const core::SuiteConfig& suite) {
  core::CekfSlam slam(suite.cekf_slam, suite.vehicle);
  Drive drive;
  for (const auto& event : recording.events) {
    if (event.sensor == core::AcfrSensor::kMotion) {
      drive.motion.emplace_back(recording.motion[event.index]);
      slam.process(drive.motion.back());
    } else if (event.sensor == core::AcfrSensor::kLaser) {
      const core::ScanEvent scan{recording.scans[event.index], suite.vehicle.laser.T_base_sensor()};
      const auto outcome = slam.process(scan);
      if (!outcome || !outcome->accepted) continue;
      drive.scans.push_back(
          {outcome->observations, outcome->associations, outcome->pose.T_map_base});
    }
  }
  drive.calibration = slam.calibration();
  drive.map = slam.landmarkMap(0.0);
  std::vector<int> ids;
  for (const auto& landmark : drive.map.landmarks) ids.push_back(landmark.id);
  slam.requestJointLandmarks(ids, [&](const core::JointLandmarks& all) { drive.joint = all; });
  return drive;
}

/// Where the vehicle was in the FINISHED map, by the landmarks that the filter took the scan's
/// observations to be of: the rigid motion that fits them best.
std::optional<core::Pose2> referencePose(const Scan& scan, const core::LandmarkMap& map) {
  std::vector<Eigen::Vector2d> seen, there;
  for (std::size_t i = 0; i < scan.associations.size(); ++i) {
    for (const auto& landmark : map.landmarks) {
      if (landmark.id != scan.associations[i].landmark_id) continue;
      const core::Observation& o = scan.set.observations[i];
      seen.push_back(scan.set.T_base_sensor * Eigen::Vector2d(o.range_m * std::cos(o.bearing_rad),
                                                              o.range_m * std::sin(o.bearing_rad)));
      there.push_back(landmark.position);
    }
  }
  if (static_cast<int>(seen.size()) < kFewestForReference) return std::nullopt;
  const auto n = static_cast<double>(seen.size());
  Eigen::Vector2d a = Eigen::Vector2d::Zero(), b = a;
  for (std::size_t i = 0; i < seen.size(); ++i) a += seen[i] / n, b += there[i] / n;
  double sine = 0.0, cosine = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Eigen::Vector2d p = seen[i] - a, q = there[i] - b;
    cosine += p.dot(q);
    sine += p.x() * q.y() - p.y() * q.x();
  }
  core::Pose2 pose{0.0, 0.0, std::atan2(sine, cosine)};
  const Eigen::Vector2d position = b - pose.rotation() * a;
  pose.x_m = position.x();
  pose.y_m = position.y();
  return pose;
}

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<core::LocalMap> makeMaps(const Drive& drive, const core::RelocaliserConfig& config) {
  std::vector<core::LocalMap> maps;
  const double spacing_m = config.neighbourhoods.spacing_m;
  for (const auto& middle : core::findMiddles(drive.map.landmarks, spacing_m)) {
    std::string problem;
    auto map =
        core::tryMakeNeighbourhood(drive.joint, middle, spacing_m, config.local_map, problem);
    if (map) maps.push_back(std::move(*map));
  }
  return maps;
}

/// CPU time of an attempt.
struct Times {
  double longest_look_s = 0.0;          ///< at a scan, in one map
  double longest_rival_piece_s = 0.0;   ///< of the search for rivals
  double longest_rival_search_s = 0.0;  ///< all its pieces for one scan
};

/// All scans that wait.
void workOff(core::PlaceSearch& search, Times& times) {
  using Progress = core::PlaceSearch::Progress;
  double rival_search_s = 0.0;
  for (auto progress = Progress::kPieceDone; progress != Progress::kNothingWaits;) {
    const bool is_of_rivals = search.isSearchingRivals();
    const double begun_s = cpu_s();
    progress = search.work();
    const double took_s = cpu_s() - begun_s;
    double& longest_s = is_of_rivals ? times.longest_rival_piece_s : times.longest_look_s;
    longest_s = std::max(longest_s, took_s);
    if (is_of_rivals) rival_search_s += took_s;
    times.longest_rival_search_s = std::max(times.longest_rival_search_s, rival_search_s);
    if (progress == Progress::kScanDone) rival_search_s = 0.0;
  }
}

/// Looks for the vehicle from a scan on; prints what came of it.
void kidnap(const Drive& drive, std::size_t first, const std::vector<core::LocalMap>& maps,
            core::PlaceSearch& search, int moment) {
  const double begun_s = drive.scans[first].set.time_s, cpu_begun_s = cpu_s();
  search.reset();
  std::string problem;
  std::size_t scans = 0;
  bool is_begun = false;
  Times times;
  auto input = drive.motion.begin();
  for (std::size_t i = first + 1; i < drive.scans.size(); ++i) {
    const Scan& scan = drive.scans[i];
    const double time_s = scan.set.time_s;
    if (time_s - begun_s > kLongest_s) break;
    for (; input != drive.motion.end() && core::timeOf(*input) <= time_s; ++input) {
      if (core::timeOf(*input) > begun_s - 1.0) search.take(*input);
    }
    search.take(scan.set);
    if (!is_begun) search.beginAnywhere(maps, drive.calibration, begun_s, problem);
    is_begun = true;
    workOff(search, times);
    ++scans;
    const auto& found = search.outcome();
    if (!found || !found->converged) continue;
    const auto reference = referencePose(scan, drive.map);
    const core::Pose2 truth = reference.value_or(scan.online);
    const core::Pose2 error = core::inverse(truth) * found->T_map_base;
    std::printf("%d,%g,1,%g,%zu,%g,%g,%d,%g,%zu,%g,%g,%g\n", moment, begun_s, time_s - begun_s,
                scans, error.position().norm(), error.yaw_rad, reference ? 1 : 0,
                cpu_s() - cpu_begun_s, search.mapsLeft(), times.longest_look_s,
                times.longest_rival_piece_s, times.longest_rival_search_s);
    return;
  }
  std::printf("%d,%g,0,nan,%zu,nan,nan,0,%g,%zu,%g,%g,%g\n", moment, begun_s, scans,
              cpu_s() - cpu_begun_s, search.mapsLeft(), times.longest_look_s,
              times.longest_rival_piece_s, times.longest_rival_search_s);
}

void run(const std::string& archive, const std::vector<std::string>& configs) {
  core::ConfigReport report;
  core::SuiteConfig suite = core::loadSuiteConfig(configs, report);
  report.throwIfUnusable();
  const Drive drive = driveAll(core::readAcfr({archive}), suite);
  core::RelocaliserConfig config = suite.relocaliser;
  config.replay_s = 0.0;  // nothing of before is known
  const std::vector<core::LocalMap> maps = makeMaps(drive, config);
  std::fprintf(stderr, "%zu scans, %zu landmarks, %zu local maps\n", drive.scans.size(),
               drive.map.landmarks.size(), maps.size());
  core::PlaceSearch search(config, suite.vehicle);
  std::puts(
      "moment,time_s,found,after_s,scans,error_m,yaw_error_rad,by_landmarks,cpu_s,maps_left,"
      "longest_look_s,longest_rival_piece_s,longest_rival_search_s");
  for (int moment = 0; moment < kMoments; ++moment) {
    const auto part = static_cast<std::size_t>(2 * moment + 1);
    kidnap(drive, part * drive.scans.size() / (2 * kMoments), maps, search, moment);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "Usage: kidnapped ARCHIVE CONFIG...\n");
    return 2;
  }
  try {
    hymm::run(argv[1], {argv + 2, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kidnapped: %s\n", error.what());
    return 1;
  }
  return 0;
}
