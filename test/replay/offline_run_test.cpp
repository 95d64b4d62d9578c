#include <iterator>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "replay/tool_run.h"
#include "support/drive_bag.h"

namespace hymm {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A folder with a bag, a configuration, and the results of runs.
class Offline : public testing::Test {
 protected:
  Offline() {
    config_ = folder_.write("config.yaml",
                            "vehicle: {ackermann: {wheelbase_m: 2.5}, laser: {x_m: 2.0}}\n");
  }

  test::ToolRun run(const std::string& bag, const std::string& results,
                    const std::string& more = "") const {
    return test::runTool(std::string(HYMM_OFFLINE) + " --bag " + bag + " --config " + config_ +
                         " --output " + (folder_ / results) + " " + more);
  }

  YAML::Node summary(const std::string& results) const {
    return YAML::LoadFile(folder_ / (results + "/summary.json"));
  }

  std::size_t lines(const std::string& file) const {
    const std::string text = folder_.read(file);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }

  /// Words of the last line of a file.
  std::vector<std::string> lastLine(const std::string& file) const {
    std::istringstream stream(folder_.read(file));
    std::string line, last;
    while (std::getline(stream, line)) last = line;
    std::istringstream words(last);
    return {std::istream_iterator<std::string>(words), {}};
  }

  test::TemporaryFolder folder_;
  std::string config_;
};

std::string withoutLatency(const std::string& health) {
  std::istringstream lines(health);
  std::string kept, line;
  while (std::getline(lines, line)) {
    const std::size_t mode = line.rfind(','), latency = line.rfind(',', mode - 1);
    kept += line.substr(0, latency) + line.substr(mode) + '\n';
  }
  return kept;
}

std::string withoutTimes(YAML::Node summary) {
  for (const char* key : {"wall_s", "cpu_s", "real_time_factor", "peak_rss_mb", "scan_latency_ms",
                          "worker_ms", "subsystem_cpu_s"}) {
    EXPECT_TRUE(summary[key]) << key;
    summary.remove(key);
  }
  return YAML::Dump(summary);
}

TEST_F(Offline, TwoRunsLeaveTheSameBytesTimesAside) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  ASSERT_EQ(run(bag, "first").exit_code, 0);
  ASSERT_EQ(run(bag, "second").exit_code, 0);
  for (const char* file : {"trajectory.tum", "pose_covariance.csv", "landmarks.csv", "gps.csv",
                           "events.csv", "ltrs.csv", "map_memory.csv"}) {
    EXPECT_EQ(folder_.read(std::string("first/") + file),
              folder_.read(std::string("second/") + file))
        << file;
  }
  EXPECT_EQ(withoutLatency(folder_.read("first/health.csv")),
            withoutLatency(folder_.read("second/health.csv")));
  EXPECT_EQ(withoutTimes(summary("first")), withoutTimes(summary("second")));
}

TEST_F(Offline, EveryScanHasItsLineAndTheMapItsTrunks) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  const test::ToolRun tool = run(bag, "results", "--only cekf_slam --seed 3");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(lines("results/trajectory.tum"), 60u);
  EXPECT_EQ(lines("results/pose_covariance.csv"), 61u);
  EXPECT_EQ(lines("results/health.csv"), 61u);
  EXPECT_EQ(lines("results/gps.csv"), 13u);
  const YAML::Node summary = this->summary("results");
  EXPECT_EQ(summary["scans"].as<int>(), 60);
  EXPECT_EQ(summary["dropped_scans"].as<int>(), 0);
  EXPECT_NEAR(summary["duration_s"].as<double>(), 11.8, 1e-9);
  EXPECT_GE(summary["landmarks"].as<int>(), 10);
  EXPECT_LE(summary["landmarks"].as<int>(), 20);
  EXPECT_LT(summary["gps_rmse_m"].as<double>(), 0.1);
  EXPECT_EQ(tool.out, "");
}

TEST_F(Offline, LogsEachObservationOnDemand) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  ASSERT_EQ(run(bag, "results", "--observations").exit_code, 0);
  EXPECT_EQ(lines("results/observations.csv"),
            1 + summary("results")["observations"].as<std::size_t>());
  EXPECT_THAT(folder_.read("results/observations.csv"),
              testing::StartsWith("t,landmark,range,bearing,"));
}

TEST_F(Offline, TopicsMayLackTheirSlashOrBeNamedOtherwise) {
  test::Drive bare;
  bare.scan_topic = "scan";
  EXPECT_EQ(run(test::writeDriveBag(folder_ / "bare.bag", bare), "bare").exit_code, 0);
  test::Drive other;
  other.scan_topic = "/front/laser";
  const std::string bag = test::writeDriveBag(folder_ / "other.bag", other);
  EXPECT_NE(run(bag, "refused").exit_code, 0);
  EXPECT_EQ(run(bag, "other", "--topic scan:=/front/laser").exit_code, 0);
  EXPECT_EQ(folder_.read("bare/trajectory.tum"), folder_.read("other/trajectory.tum"));
}

TEST_F(Offline, RunsOnOdometryOnDemand) {
  test::Drive drive;
  drive.has_dead_reckoning = false;
  drive.has_odom = true;
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", drive);
  const std::string odom = folder_.write("odom.yaml", "cekf_slam: {motion_input: odom}\n");
  const test::ToolRun tool = run(bag, "results", "--config " + odom);
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 60);
}

TEST_F(Offline, TellsOfClocksThatDisagreeByHowMuch) {
  test::Drive drive;
  drive.recorded_later_s = 0.05;
  const std::string bag = test::writeDriveBag(folder_ / "one.bag", drive);
  const test::ToolRun fine = run(bag, "one");
  ASSERT_EQ(fine.exit_code, 0) << fine.err;
  EXPECT_THAT(fine.err, Not(HasSubstr("clocks")));
  drive.motion_ahead_s = 0.9;
  const test::ToolRun apart = run(test::writeDriveBag(folder_ / "two.bag", drive), "two");
  ASSERT_EQ(apart.exit_code, 0) << apart.err;
  EXPECT_THAT(apart.err, HasSubstr("motion are 0.900 s ahead of those of scans"));
}

TEST_F(Offline, RunsOnDetectionsOnDemand) {
  test::Drive drive;
  drive.has_scans = false;
  drive.has_detections = true;
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", drive);
  const std::string own = folder_.write("own.yaml", "cekf_slam: {observation_input: detections}\n");
  const test::ToolRun tool = run(bag, "results", "--config " + own);
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 60);
  EXPECT_GE(summary("results")["landmarks"].as<int>(), 5);
}

TEST_F(Offline, RunsOnCloudsOnDemandAndMapsThem) {
  test::Drive drive;
  drive.has_scans = false;
  drive.has_points = true;
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", drive);
  const std::string own = folder_.write(
      "own.yaml", "cekf_slam: {observation_input: points}\nhymm_grid: {scan_input: points}\n");
  const test::ToolRun tool = run(bag, "results", "--config " + own);
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  const YAML::Node points = summary("results");
  EXPECT_EQ(points["scans"].as<int>(), 60);
  EXPECT_EQ(points["dropped_scans"].as<int>(), 0);

  // As a laser in the lidar's place.
  ASSERT_EQ(run(test::writeDriveBag(folder_ / "b.bag", {}), "scans").exit_code, 0);
  const YAML::Node scans = summary("scans");
  EXPECT_NEAR(points["landmarks"].as<int>(), scans["landmarks"].as<int>(), 1);
  EXPECT_NEAR(points["ltrs"].as<int>(), scans["ltrs"].as<int>(), 2);
  EXPECT_GT(points["ltrs"].as<int>(), 5);
}

TEST_F(Offline, SecondRecordingInABagBeginsANewMap) {
  test::Drive first, second;
  second.begin_s = 20.0;
  second.recorded_later_s = 200.0;
  rosbag::Bag bag(folder_ / "both.bag", rosbag::bagmode::Write);
  test::writeDrive(bag, first);
  test::writeDrive(bag, second);
  bag.close();
  const test::ToolRun tool = run(folder_ / "both.bag", "both");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_THAT(tool.err, HasSubstr("clock ran back"));
  EXPECT_EQ(lines("both/trajectory.tum"), 120u);
  EXPECT_EQ(summary("both")["resets"].as<int>(), 1);
  EXPECT_NEAR(summary("both")["duration_s"].as<double>(), 23.6, 1e-9);

  ASSERT_EQ(run(test::writeDriveBag(folder_ / "second.bag", second), "second").exit_code, 0);
  const std::string alone = folder_.read("second/trajectory.tum");
  const std::string together = folder_.read("both/trajectory.tum");
  EXPECT_EQ(together.substr(together.size() - alone.size()), alone);
  EXPECT_EQ(folder_.read("both/landmarks.csv"), folder_.read("second/landmarks.csv"));
}

TEST_F(Offline, UnusableScansAreCountedAndTheRestIsUsed) {
  test::Drive drive;
  drive.spoil = [](sensor_msgs::LaserScan& scan, int index) {
    if (index == 10) scan.intensities.resize(17);
    if (index == 20) scan.angle_increment = 0.0F;
    if (index == 30) std::fill(scan.ranges.begin(), scan.ranges.end(), INFINITY);
    if (index == 40) scan.ranges[100] = NAN;
  };
  const test::ToolRun tool = run(test::writeDriveBag(folder_ / "a.bag", drive), "results");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 59);
  EXPECT_EQ(summary("results")["dropped_scans"].as<int>(), 1);
  EXPECT_THAT(tool.err, HasSubstr("refused"));
  EXPECT_THAT(tool.err, HasSubstr("intensities are not as many as their ranges: 1"));
  EXPECT_EQ(lines("results/trajectory.tum"), 59u);
}

TEST_F(Offline, ScansThatAreLateOrRepeatedAreDroppedAndCounted) {
  test::Drive drive;
  drive.spoil = [](sensor_msgs::LaserScan& scan, int index) {
    if (index == 20) scan.header.stamp -= ros::Duration(0.5);  // older than the one before
    if (index == 30) scan.header.stamp -= ros::Duration(0.2);  // of the same time
  };
  const test::ToolRun tool = run(test::writeDriveBag(folder_ / "a.bag", drive), "results");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 58);
  EXPECT_EQ(summary("results")["dropped_scans"].as<int>(), 2);
  EXPECT_EQ(summary("results")["resets"].as<int>(), 0);
  EXPECT_THAT(tool.err, HasSubstr("older than what was processed: 1"));
  EXPECT_THAT(tool.err, HasSubstr("not later than the last one: 1"));
}

TEST_F(Offline, AGapOfOdometryIsCountedAndBridged) {
  test::Drive drive;
  drive.lost_motion_from_s = 3.0;
  drive.lost_motion_to_s = 8.0;
  const test::ToolRun tool = run(test::writeDriveBag(folder_ / "a.bag", drive), "results");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 60);
  EXPECT_THAT(tool.err, HasSubstr("gaps in the motion input: 1"));
  // The trunks hold the estimate: 3 m/s for 11.8 s.
  const std::vector<std::string> last = lastLine("results/trajectory.tum");
  EXPECT_NEAR(std::stod(last.at(1)), 35.4, 0.5);
  EXPECT_NEAR(std::stod(last.at(2)), 0.0, 0.5);
}

TEST_F(Offline, NegativeRangesAreCountedAndNotUsed) {
  test::Drive drive;
  drive.spoil = [](sensor_msgs::LaserScan& scan, int index) {
    if (index % 10 == 0) scan.ranges[5] = -1.0F;
  };
  const test::ToolRun tool = run(test::writeDriveBag(folder_ / "a.bag", drive), "results");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_EQ(summary("results")["scans"].as<int>(), 60);
  EXPECT_THAT(tool.err, HasSubstr("scans with negative ranges: 6"));
}

TEST_F(Offline, WithoutTfTheVehicleTellsWhereTheLaserStands) {
  test::Drive drive;
  drive.has_tf = false;
  const std::string bag = test::writeDriveBag(folder_ / "no_tf.bag", drive);
  const test::ToolRun tool = run(bag, "no_tf");
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  EXPECT_THAT(tool.err, HasSubstr("the vehicle's description is used"));
  ASSERT_EQ(run(test::writeDriveBag(folder_ / "tf.bag", {}), "tf").exit_code, 0);
  EXPECT_EQ(folder_.read("no_tf/trajectory.tum"), folder_.read("tf/trajectory.tum"));
}

TEST_F(Offline, RefusesSubsystemsThatItDoesNotHave) {
  const test::ToolRun tool =
      run(test::writeDriveBag(folder_ / "a.bag", {}), "results", "--only cekf_slam,hymm_gird");
  EXPECT_NE(tool.exit_code, 0);
  EXPECT_THAT(tool.err, AllOf(HasSubstr("hymm_gird"), HasSubstr("cekf_slam, hymm_grid")));
}

TEST_F(Offline, WritesTheDenseMapUnlessItIsLeftOut) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  ASSERT_EQ(run(bag, "all").exit_code, 0);
  EXPECT_GT(summary("all")["ltrs"].as<std::size_t>(), 0u);
  EXPECT_EQ(lines("all/ltrs.csv"), 1 + summary("all")["ltrs"].as<std::size_t>());
  EXPECT_TRUE(summary("all")["subsystem_cpu_s"]["hymm_grid"]);
  EXPECT_EQ(lines("all/map_memory.csv"), 3u);  // at 0 s and 10 s

  ASSERT_EQ(run(bag, "filter", "--only cekf_slam").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "filter/ltrs.csv"));
  EXPECT_FALSE(summary("filter")["subsystem_cpu_s"]["hymm_grid"]);
  EXPECT_EQ(summary("filter")["ltrs"].as<std::size_t>(), 0u);
}

TEST_F(Offline, TheDenseMapDoesNotChangeAFilterThatDropsNothing) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  ASSERT_EQ(run(bag, "all").exit_code, 0);
  ASSERT_EQ(run(bag, "filter", "--only cekf_slam").exit_code, 0);
  EXPECT_EQ(folder_.read("all/trajectory.tum"), folder_.read("filter/trajectory.tum"));
}

TEST_F(Offline, EvaluatesWhatItWrote) {
  ASSERT_EQ(run(test::writeDriveBag(folder_ / "a.bag", {}), "results").exit_code, 0);
  const test::ToolRun tool =
      test::runTool(std::string(HYMM_EVALUATE) + " --results " + (folder_ / "results"));
  ASSERT_EQ(tool.exit_code, 0) << tool.err;
  const YAML::Node json = YAML::Load(tool.out);
  EXPECT_EQ(json["gps"]["count"].as<int>(), 12);
  EXPECT_NEAR(json["gps"]["rmse_m"].as<double>(), summary("results")["gps_rmse_m"].as<double>(),
              1e-6);
  EXPECT_NEAR(json["nis"]["mean_per_dof"].as<double>(), summary("results")["nis_mean"].as<double>(),
              1e-9);
}

}  // namespace
}  // namespace hymm
