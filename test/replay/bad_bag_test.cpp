#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "replay/tool_run.h"
#include "support/drive_bag.h"

namespace hymm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Runs hymm_offline on a bag that it has to refuse.
class BadBag : public testing::Test {
 protected:
  /// What the tool says; fails unless it exits with an error of its own and leaves no summary.
  std::string refusal(const std::string& bag, const std::string& more = "") const {
    const test::ToolRun tool = test::runTool(std::string(HYMM_OFFLINE) + " --bag " + bag +
                                             " --output " + (folder_ / "results") + " " + more);
    EXPECT_EQ(tool.exit_code, 1) << tool.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "results/summary.json"));
    return tool.err;
  }

  test::TemporaryFolder folder_;
};

TEST_F(BadBag, MissingFileIsNamed) {
  EXPECT_THAT(refusal(folder_ / "none.bag"), HasSubstr("none.bag: there is no such file"));
}

TEST_F(BadBag, EmptyFile) {
  EXPECT_THAT(refusal(folder_.write("a.bag", "")), HasSubstr("empty (0 bytes)"));
}

TEST_F(BadBag, FileThatIsNoBag) {
  EXPECT_THAT(refusal(folder_.write("a.bag", "vehicle: utility_car\n")), HasSubstr("a.bag"));
}

TEST_F(BadBag, BagWithoutMessages) {
  rosbag::Bag(folder_ / "a.bag", rosbag::bagmode::Write).close();
  EXPECT_THAT(refusal(folder_ / "a.bag"), HasSubstr("holds no messages"));
}

TEST_F(BadBag, CutOffAnywhere) {
  const std::string bag = test::writeDriveBag(folder_ / "whole.bag", {});
  const auto size = static_cast<double>(std::filesystem::file_size(bag));
  for (const double share : {0.00002, 0.002, 0.01, 0.1, 0.5, 0.9, 0.99, 0.9999}) {
    SCOPED_TRACE(share);
    const std::string cut = folder_ / "cut.bag";
    std::filesystem::copy_file(bag, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, static_cast<std::uintmax_t>(share * size));
    EXPECT_THAT(refusal(cut), AllOf(HasSubstr("cut.bag"), HasSubstr("rosbag reindex")));
  }
}

TEST_F(BadBag, DamagedAnywhere) {
  const std::string bag = test::writeDriveBag(folder_ / "whole.bag", {});
  const std::string whole = folder_.read("whole.bag");
  for (int part = 1; part < 20; ++part) {
    SCOPED_TRACE(part);
    std::string damaged = whole;
    const std::size_t begin = whole.size() * static_cast<std::size_t>(part) / 20;
    for (std::size_t i = begin; i < std::min(begin + 4096, whole.size()); ++i) {
      damaged[i] = static_cast<char>(damaged[i] ^ 0x5a);
    }
    const test::ToolRun tool = test::runTool(std::string(HYMM_OFFLINE) + " --bag " +
                                             folder_.write("a.bag", damaged).string() +
                                             " --output " + (folder_ / "results"));
    // Damage to a few messages may be survived, damage to the structure not; neither may crash.
    EXPECT_TRUE(tool.exit_code == 0 || tool.exit_code == 1) << tool.exit_code << ": " << tool.err;
    if (tool.exit_code == 1) {
      EXPECT_THAT(tool.err, HasSubstr("a.bag"));
    }
  }
}

TEST_F(BadBag, WithoutScansTellsWhatItHolds) {
  test::Drive drive;
  drive.has_scans = false;
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", drive)),
              AllOf(HasSubstr("'scan'"), HasSubstr("/dead_reckoning (hymm/DeadReckoning, 240)"),
                    HasSubstr("/gps/fix")));
}

TEST_F(BadBag, WithoutOdometryTellsWhatItHolds) {
  test::Drive drive;
  drive.has_dead_reckoning = false;
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", drive)),
              AllOf(HasSubstr("'dead_reckoning'"), HasSubstr("/scan (sensor_msgs/LaserScan, 60)"),
                    HasSubstr("motion_input")));
}

TEST_F(BadBag, AnotherTypeUnderTheNameOfATopic) {
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", {}), "--topic scan:=/gps/fix"),
              AllOf(HasSubstr("sensor_msgs/NavSatFix"), HasSubstr("sensor_msgs/LaserScan")));
}

TEST_F(BadBag, AnotherNameForATopicThatNobodyTakes) {
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", {}), "--topic scn:=/front/scan"),
              AllOf(HasSubstr("'scn' is no input"), HasSubstr("odom, points")));
}

TEST_F(BadBag, LaserThatStandsNobodyKnowsWhere) {
  test::Drive drive;
  drive.has_tf = false;
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", drive)), HasSubstr("'laser'"));
}

TEST_F(BadBag, MotionThatNobodyStamped) {
  test::Drive drive;
  drive.motion_has_stamps = false;
  EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", drive)),
              AllOf(HasSubstr("No motion input could be used"), HasSubstr("no time stamp: 240")));
}

TEST_F(BadBag, MotionOfAnotherTimeThanTheScans) {
  for (const double ahead_s : {3600.0, -95.0, 1.7e9}) {
    test::Drive drive;
    drive.motion_ahead_s = ahead_s;
    EXPECT_THAT(refusal(test::writeDriveBag(folder_ / "a.bag", drive)),
                AllOf(HasSubstr("not of one time"), HasSubstr("Motion is stamped from")))
        << ahead_s;
  }
}

TEST_F(BadBag, ConfigurationsAreRefusedWithAllTheirProblems) {
  const std::string bag = test::writeDriveBag(folder_ / "a.bag", {});
  const std::string config = folder_.write("c.yaml", "vehicle: {length_m: -1, width_m: wide}\n");
  EXPECT_THAT(refusal(bag, "--config " + config),
              AllOf(HasSubstr("length_m"), HasSubstr("width_m")));
}

}  // namespace
}  // namespace hymm
