#include <cstdlib>
#include <stdexcept>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "replay/tool_run.h"

namespace hymm {
namespace {

/// What hymm_evaluate says of the bundled bag, run as the demo runs it.
YAML::Node evaluateDemo() {
  const char* source = std::getenv("HYMM_SOURCE_DIR");
  if (source == nullptr) throw std::runtime_error("HYMM_SOURCE_DIR is not set: run by ctest");
  const test::TemporaryFolder folder;
  const std::string bag = std::string(source) + "/bags/car_park.bag";
  const std::string results = folder / "results";
  const test::ToolRun run =
      test::runTool(std::string(HYMM_OFFLINE) + " --bag " + bag + " --config " + source +
                    "/config/datasets/car_park.yaml --output " + results);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const test::ToolRun evaluation =
      test::runTool(std::string(HYMM_EVALUATE) + " --results " + results + " --bag " + bag);
  EXPECT_EQ(evaluation.exit_code, 0) << evaluation.err;
  return YAML::Load(evaluation.out);
}

// The landmarks are posts whose centres one scan tells to some 3 cm, and each is seen in dozens of
// scans: a map and a trajectory that follow from them are good to a decimetre wherever the car
// drives.
TEST(DemoBag, LocatesTheCarToADecimetreAsItClaims) {
  const YAML::Node figures = evaluateDemo();
  const YAML::Node trajectory = figures["trajectory"];
  EXPECT_EQ(trajectory["count"].as<int>(), 893);
  EXPECT_LT(trajectory["rmse_m"].as<double>(), 0.1);
  EXPECT_LT(trajectory["heading_rmse_rad"].as<double>(), 0.01);
  EXPECT_GT(trajectory["nees"]["share_in_95_percent_band"].as<double>(), 0.9);

  const YAML::Node landmarks = figures["landmarks"];
  EXPECT_GT(landmarks["matched"].as<int>(), 55);
  EXPECT_EQ(landmarks["false"].as<int>(), 0);
  EXPECT_LT(landmarks["rmse_m"].as<double>(), 0.1);
}

}  // namespace
}  // namespace hymm
