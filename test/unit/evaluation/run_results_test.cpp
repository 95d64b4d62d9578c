#include "evaluation/run_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "evaluation/csv_table.h"
#include "pipeline/results_writer.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

ScanRecord scanAt(double time_s) {
  ScanRecord record;
  record.pose.time_s = time_s;
  record.pose.T_map_base = {time_s, -time_s, 3.0};
  record.pose.covariance << 1, 0.1, 0.2, 0.1, 2, 0.3, 0.2, 0.3, 3;
  record.health.nis = 5.0;
  record.health.dof = 6;
  record.mode = "CEKF";
  return record;
}

std::string problemOf(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no problem";
}

TEST(RunResults, ReadsBackWhatWasWritten) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder.path().string());
  writer.addScan(scanAt(1.5));
  writer.addGps({1.5, {7.0, 8.0}});
  LandmarkMap map;
  map.landmarks.resize(1);
  map.landmarks[0].id = 4;
  map.landmarks[0].position = {0.5, 0.25};
  map.landmarks[0].covariance << 0.5, 0.125, 0.125, 0.75;
  RunTotals totals;
  totals.gps_antenna_m = Eigen::Vector2d(3.78, 0.5);
  writer.finish(map, totals);

  const RunResults results = readRunResults(folder.path().string());
  ASSERT_THAT(results.poses, SizeIs(1));
  EXPECT_EQ(results.poses[0].pose.time_s, 1.5);
  EXPECT_EQ(results.poses[0].pose.pose.x_m, 1.5);
  EXPECT_NEAR(results.poses[0].pose.pose.yaw_rad, 3.0, 1e-15);
  EXPECT_EQ(results.poses[0].covariance, scanAt(1.5).pose.covariance);
  ASSERT_THAT(results.nis, SizeIs(1));
  EXPECT_EQ(results.nis[0].dof, 6);
  ASSERT_THAT(results.landmarks, SizeIs(1));
  EXPECT_EQ(results.landmarks[0].covariance, map.landmarks[0].covariance);
  ASSERT_THAT(results.gps, SizeIs(1));
  EXPECT_EQ(results.gps[0].position, Eigen::Vector2d(7.0, 8.0));
  EXPECT_EQ(results.gps_antenna, Eigen::Vector2d(3.78, 0.5));
}

TEST(RunResults, HoldWhatFollowsTheLastReset) {
  const test::TemporaryFolder folder;
  ResultsWriter writer(folder.path().string());
  for (const double t : {100.0, 101.0}) {
    writer.addScan(scanAt(t));
    writer.addGps({t, {t, 0.0}});
  }
  writer.addReset(3.0, "the clock ran back");
  writer.addScan(scanAt(3.0));
  writer.addGps({3.0, {3.0, 0.0}});
  writer.finish({}, {});
  const RunResults results = readRunResults(folder.path().string());
  EXPECT_EQ(results.resets, 1u);
  ASSERT_THAT(results.poses, SizeIs(1));
  EXPECT_EQ(results.poses[0].pose.time_s, 3.0);
  ASSERT_THAT(results.gps, SizeIs(1));
  EXPECT_THAT(results.nis, SizeIs(1));
}

TEST(RunResults, NameTheFileThatIsMissing) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(problemOf([&] { readRunResults(folder / "none"); }), HasSubstr("none"));
  EXPECT_THAT(problemOf([&] { readRunResults(folder.path().string()); }), HasSubstr("events.csv"));
}

TEST(RunResults, LeaveOutWhatCameAfterTheSummary) {
  const test::TemporaryFolder folder;
  {
    ResultsWriter writer(folder.path().string());
    writer.addScan(scanAt(1.0));
    writer.finish({}, {});
  }
  folder.write("trajectory.tum", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  EXPECT_THAT(readRunResults(folder.path().string()).poses, SizeIs(1));
}

TEST(RunResults, SayThatLinesAreMissing) {
  const test::TemporaryFolder folder;
  {
    ResultsWriter writer(folder.path().string());
    writer.addScan(scanAt(1.0));
    writer.finish({}, {});
  }
  folder.write("trajectory.tum", "");
  EXPECT_THAT(problemOf([&] { readRunResults(folder.path().string()); }),
              AllOf(HasSubstr("0 poses"), HasSubstr("tells of 1")));
}

TEST(Fixes, AcfrRowsAreTimeNorthEast) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("GPS.txt", "0.5\t10.0\t20.0\n1.5\t11.0\t21.0\n");
  const auto fixes = readFixes(file);
  ASSERT_THAT(fixes, SizeIs(2));
  EXPECT_EQ(fixes[0].time_s, 0.5);
  EXPECT_EQ(fixes[0].position, Eigen::Vector2d(20.0, 10.0));
}

TEST(Fixes, CsvColumnsAreFoundByName) {
  const test::TemporaryFolder folder;
  const auto fixes = readFixes(folder.write("gps.csv", "x,quality,t,y\n20,4,0.5,10\n"));
  ASSERT_THAT(fixes, SizeIs(1));
  EXPECT_EQ(fixes[0].time_s, 0.5);
  EXPECT_EQ(fixes[0].position, Eigen::Vector2d(20.0, 10.0));
}

TEST(CsvTable, NamesLineAndColumnOfWhatIsNoNumber) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("a.csv", "t,x\n1,2\n3,four\n");
  EXPECT_THAT(problemOf([&] { CsvTable(file).numbers("x"); }),
              AllOf(HasSubstr("line 3"), HasSubstr("'x'"), HasSubstr("'four'")));
  EXPECT_THAT(problemOf([&] { CsvTable(file).numbers("y"); }), HasSubstr("no column 'y'"));
}

TEST(CsvTable, RefusesALineOfAnotherLength) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("a.csv", "t,x\n1,2\n3\n");
  EXPECT_THAT(problemOf([&] { CsvTable table(file); }), HasSubstr("line 3"));
}

TEST(CsvTable, ReadsQuotedFields) {
  const test::TemporaryFolder folder;
  const CsvTable table(folder.write("a.csv", "t,reason\r\n1,\"so, \"\"so\"\"\"\r\n"));
  EXPECT_THAT(table.texts("reason"), ElementsAre("so, \"so\""));
}

}  // namespace
}  // namespace hymm::core
