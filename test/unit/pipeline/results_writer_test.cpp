#include "pipeline/results_writer.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include "common/error.h"
#include "evaluation/run_results.h"
#include "support/full_disk.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

ScanRecord scanAt(double time_s, double x_m) {
  ScanRecord record;
  record.pose.time_s = time_s;
  record.pose.T_map_base = {x_m, 2.0, kPi / 2.0};
  record.pose.covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  record.health.nis = 3.0;
  record.health.dof = 4;
  record.health.latency_ms = 0.5;
  record.mode = "CEKF";
  return record;
}

LandmarkMap oneLandmark() {
  LandmarkEstimate landmark;
  landmark.id = 7;
  landmark.type = LandmarkType::kTrunk;
  landmark.position = {1.5, -2.5};
  landmark.covariance << 0.04, 0.01, 0.01, 0.09;
  landmark.diameter_m = 0.3;
  landmark.observations = 12;
  LandmarkMap map;
  map.landmarks = {landmark};
  return map;
}

RunTotals totals() {
  RunTotals totals;
  totals.wall_s = 0.5;
  totals.cpu_s = 0.4;
  totals.peak_rss_mb = 30.0;
  totals.observations = 20;
  totals.associated = 8;
  totals.rejected = 4;
  totals.subsystem_cpu_s = {{"filter", 0.1}, {"worker", 0.02}};
  return totals;
}

TEST(ResultsWriter, WritesTheFilesWithTheirHeaders) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "a/b");
  writer.addScan(scanAt(10.25, 1.0));
  writer.addGps({10.25, {3.0, 4.0}});
  writer.finish(oneLandmark(), totals());
  EXPECT_THAT(folder.read("a/b/trajectory.tum"), StartsWith("10.25 1 2 0 0 0 0.7071067811865"));
  EXPECT_EQ(folder.read("a/b/pose_covariance.csv"),
            "t,xx,xy,xyaw,yy,yyaw,yawyaw\n10.25,1,2,3,4,5,6\n");
  EXPECT_EQ(folder.read("a/b/landmarks.csv"),
            "id,type,x,y,cxx,cxy,cyy,diameter,observations\n"
            "7,trunk,1.5,-2.5,0.04,0.01,0.09,0.3,12\n");
  EXPECT_EQ(folder.read("a/b/health.csv"),
            "t,nis,dof,ambiguity,unexplained,missed,latency_ms,mode\n"
            "10.25,3,4,0,0,0,0.5,CEKF\n");
  EXPECT_EQ(folder.read("a/b/gps.csv"), "t,x,y,cxx,cxy,cyy\n10.25,3,4,1,0,1\n");
  EXPECT_EQ(folder.read("a/b/events.csv"), "t,scan,event,mode,reason\n");
}

TEST(ResultsWriter, SummaryHoldsEveryKeyOfTheContract) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  for (int i = 0; i < 4; ++i) writer.addScan(scanAt(i, i));
  writer.finish(oneLandmark(), totals());
  const YAML::Node summary = YAML::Load(folder.read("summary.json"));
  for (const char* key : {"scans",
                          "duration_s",
                          "wall_s",
                          "cpu_s",
                          "real_time_factor",
                          "peak_rss_mb",
                          "landmarks",
                          "ltrs",
                          "observations",
                          "associated",
                          "rejected",
                          "scan_latency_ms",
                          "subsystem_cpu_s",
                          "worker_ms",
                          "global_updates",
                          "deferred_global_updates",
                          "global_update_waits",
                          "nis_mean",
                          "gps_rmse_m",
                          "map_corrections",
                          "mode_switches",
                          "dropped_scans"}) {
    EXPECT_TRUE(summary[key]) << key;
  }
  for (const char* key : {"p50", "p95", "p99", "p999", "max"}) {
    EXPECT_EQ(summary["scan_latency_ms"][key].as<double>(), 0.5) << key;
  }
  EXPECT_EQ(summary["scans"].as<int>(), 4);
  EXPECT_EQ(summary["duration_s"].as<double>(), 3.0);
  EXPECT_EQ(summary["real_time_factor"].as<double>(), 6.0);
  EXPECT_EQ(summary["observations"].as<int>(), 20);
  EXPECT_EQ(summary["associated"].as<int>(), 8);
  EXPECT_EQ(summary["rejected"].as<int>(), 4);
  EXPECT_EQ(summary["worker_ms"].as<double>(), 5.0);
  EXPECT_EQ(summary["nis_mean"].as<double>(), 0.75);
  EXPECT_EQ(summary["landmarks"].as<int>(), 1);
  EXPECT_TRUE(summary["gps_rmse_m"].IsNull());
}

TEST(ResultsWriter, DurationLeavesOutTheJumpBetweenRecordings) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  writer.addScan(scanAt(100.0, 0.0));
  writer.addScan(scanAt(110.0, 1.0));
  writer.addReset(5.0, "the clock ran back");
  writer.addScan(scanAt(5.0, 0.0));
  writer.addScan(scanAt(8.0, 1.0));
  writer.finish({}, totals());
  const YAML::Node summary = YAML::Load(folder.read("summary.json"));
  EXPECT_EQ(summary["scans"].as<int>(), 4);
  EXPECT_EQ(summary["duration_s"].as<double>(), 13.0);
  EXPECT_EQ(summary["resets"].as<int>(), 1);
  EXPECT_THAT(folder.read("events.csv"), HasSubstr("\n5,2,reset,CEKF,the clock ran back\n"));
}

TEST(ResultsWriter, QuotesReasonsThatHoldCommas) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  writer.addModeSwitch(1.0, "LOST", "so it is, \"lost\"");
  writer.finish({}, totals());
  EXPECT_THAT(folder.read("events.csv"),
              HasSubstr("\n1,0,mode_switch,LOST,\"so it is, \"\"lost\"\"\"\n"));
}

TEST(ResultsWriter, ARunWithoutScansHasAnEmptySummary) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  writer.finish({}, totals());
  const YAML::Node summary = YAML::Load(folder.read("summary.json"));
  EXPECT_EQ(summary["scans"].as<int>(), 0);
  EXPECT_EQ(summary["duration_s"].as<double>(), 0.0);
  EXPECT_TRUE(summary["nis_mean"].IsNull());
}

TEST(ResultsWriter, ResultsOfAnEarlierRunStayUntilTheFirstScan) {
  const test::TemporaryFolder folder;
  for (const char* name : {"summary.json", "trajectory.tum", "map.pgm"}) folder.write(name, "old");
  ResultsWriter writer(folder / "");
  writer.addGps({9.0, {3.0, 4.0}});
  for (const char* name : {"summary.json", "trajectory.tum", "map.pgm"}) {
    EXPECT_EQ(folder.read(name), "old") << name;
  }
  writer.addScan(scanAt(10.0, 1.0));
  EXPECT_FALSE(std::filesystem::exists(folder / "summary.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "map.pgm"));
  EXPECT_THAT(folder.read("trajectory.tum"), StartsWith("10 1 2"));
}

TEST(ResultsWriter, WithoutAScanOnlyTheEndReplacesAnEarlierRun) {
  const test::TemporaryFolder folder;
  folder.write("map.pgm", "old");
  { const ResultsWriter writer(folder / ""); }
  EXPECT_EQ(folder.read("map.pgm"), "old");
  ResultsWriter(folder / "").finish({}, totals());
  EXPECT_FALSE(std::filesystem::exists(folder / "map.pgm"));
}

TEST(ResultsWriter, AFullDiskCostsNothingOnceThereIsRoomAgain) {
  constexpr int kScans = 60000;
  const test::TemporaryFolder full, never_full;
  ResultsWriter writer(full / ""), other(never_full / "");
  std::size_t failures = 0;
  for (int i = 0; i < kScans; ++i) {
    other.addScan(scanAt(i, i));
    std::optional<test::FullDisk> disk;
    if (i >= 10000 && i < 50000) disk.emplace(3072);
    try {
      writer.addScan(scanAt(i, i));
    } catch (const OutputError&) {
      ++failures;
    }
    if (i == 30000) {
      EXPECT_THROW(writer.save(oneLandmark(), totals()), OutputError);
    }
  }
  EXPECT_GE(failures, 1u);
  EXPECT_LE(failures, 10u) << "all that waits is handed over with every scan";
  writer.finish(oneLandmark(), totals());
  other.finish(oneLandmark(), totals());
  for (const char* name : {"trajectory.tum", "pose_covariance.csv", "health.csv", "gps.csv",
                           "events.csv", "landmarks.csv", "summary.json"}) {
    EXPECT_TRUE(full.read(name) == never_full.read(name)) << name;
  }
}

TEST(ResultsWriter, LinesReachTheDiskWhileTheRunGoesOn) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  for (int i = 0; i < 20000; ++i) writer.addScan(scanAt(i, i));
  const auto lines = [&](const char* name) {
    const std::string text = folder.read(name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_GT(lines("trajectory.tum"), 10000);
  EXPECT_EQ(lines("pose_covariance.csv"), lines("trajectory.tum") + 1);
  EXPECT_EQ(lines("health.csv"), lines("trajectory.tum") + 1);
}

TEST(ResultsWriter, SavesACompleteFolderWhileTheRunGoesOn) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder / "");
  writer.addScan(scanAt(10.0, 1.0));
  writer.save(oneLandmark(), totals());
  writer.addScan(scanAt(11.0, 2.0));
  const RunResults saved = readRunResults(folder / "");
  EXPECT_EQ(saved.poses.size(), 1u);
  EXPECT_EQ(saved.landmarks.size(), 1u);
  EXPECT_THAT(folder.read("summary.json"), HasSubstr("it had not ended"));

  writer.finish(oneLandmark(), totals());
  EXPECT_EQ(readRunResults(folder / "").poses.size(), 2u);
  EXPECT_THAT(folder.read("summary.json"), Not(HasSubstr("it had not ended")));
}

/// Adds and saves until it is killed.
[[noreturn]] void recordForEver(const std::string& folder) {
  ResultsWriter writer(folder);
  for (int i = 0;; ++i) {
    writer.addScan(scanAt(i, i));
    writer.addGps({static_cast<double>(i), {1.0, 2.0}});
    writer.save(oneLandmark(), totals());
  }
}

TEST(ResultsWriter, AKillAtAnyMomentLeavesACompleteFolder) {
  for (int attempt = 0; attempt < 30; ++attempt) {
    const test::TemporaryFolder folder;
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) recordForEver(folder / "");
    while (!std::filesystem::exists(folder / "summary.json")) usleep(100);
    usleep(static_cast<useconds_t>(137 * attempt));  // so that each kill hits another moment
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const RunResults results = readRunResults(folder / "");
    EXPECT_EQ(results.landmarks.size(), 1u);
    EXPECT_GE(results.poses.size(), 1u);
    EXPECT_EQ(results.nis.size(), results.poses.size());
    EXPECT_GE(results.gps.size(), results.poses.size());
  }
}

TEST(ResultsWriter, TellsThatAFolderCannotBeWritten) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("file", "");
  try {
    ResultsWriter writer(file + "/results");
    FAIL() << "made a folder below a file";
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file + "/results"));
  }
}

}  // namespace
}  // namespace hymm::core
