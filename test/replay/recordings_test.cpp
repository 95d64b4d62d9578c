#include "support/recordings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "replay/tool_run.h"

namespace hymm {
namespace {

constexpr char kMrclam[] = "mrclam/mrclam_ds6_robots12.zip";
constexpr char kDlr[] = "dlr/map.circles";

TEST(Recordings, MrclamIsFilteredAndComparedWithItsTruth) {
  HYMM_SKIP_WITHOUT_RECORDING(kMrclam);
  const test::TemporaryFolder folder;
  const std::string source =
      " --dataset mrclam " + test::recording(kMrclam).string() + " --robot 2";
  const test::ToolRun run =
      test::runTool(std::string(HYMM_OFFLINE) + source + " --output " + folder.path().string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const test::ToolRun evaluation =
      test::runTool(std::string(HYMM_EVALUATE) + source + " --results " + folder.path().string());
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.err;
  const YAML::Node json = YAML::Load(evaluation.out);
  EXPECT_EQ(json["landmarks"]["matched"].as<int>(), 15);
  EXPECT_EQ(json["landmarks"]["false"].as<int>(), 0);
  // Twice the deviation of a single range (0.17 m): what a working filter stays under.
  EXPECT_LT(json["trajectory"]["aligned"]["rmse_m"].as<double>(), 0.34);
}

TEST(Recordings, EveryStepOfDlrHasItsLine) {
  HYMM_SKIP_WITHOUT_RECORDING(kDlr);
  const test::TemporaryFolder folder;
  const test::ToolRun run =
      test::runTool(std::string(HYMM_OFFLINE) + " --dataset dlr " + test::recording(kDlr).string() +
                    " --output " + folder.path().string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(YAML::LoadFile(folder / "summary.json")["scans"].as<int>(), 3297);
}

TEST(Recordings, UnknownKindIsRefused) {
  const test::TemporaryFolder folder;
  const test::ToolRun run = test::runTool(std::string(HYMM_OFFLINE) +
                                          " --dataset kitti nowhere --output " + (folder / "out"));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, testing::HasSubstr("mrclam and dlr"));
}

}  // namespace
}  // namespace hymm
