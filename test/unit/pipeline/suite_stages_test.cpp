#include "pipeline/suite_stages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace hymm::core {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

std::vector<std::string> problemsOf(const std::vector<std::string>& only) {
  try {
    chosenNodes(only);
  } catch (const ConfigError& error) {
    return error.problems();
  }
  return {};
}

TEST(SuiteStages, AllNodesRunUnlessSomeAreNamed) {
  EXPECT_EQ(chosenNodes({}), nodeNames());
  EXPECT_THAT(chosenNodes({"cekf_slam"}), ElementsAre("cekf_slam"));
  EXPECT_THAT(nodeNames(), Contains("hymm_grid"));
}

TEST(SuiteStages, UnknownNamesAreRefusedWithThoseThereAre) {
  EXPECT_THAT(problemsOf({"cekf_slam", "hymm_gird", "slam"}),
              ElementsAre(HasSubstr("'hymm_gird'"), HasSubstr(listOf(nodeNames()))));
}

TEST(SuiteStages, NothingRunsWithoutTheFilter) {
  EXPECT_THAT(problemsOf({"hymm_grid"}), ElementsAre(HasSubstr("cekf_slam; name it as well")));
}

TEST(SuiteStages, AreMadeForTheNamedNodesOnly) {
  const SuiteConfig config;
  EXPECT_THAT(makeStages({"cekf_slam"}, config), SizeIs(0));
  EXPECT_THAT(makeStages({"cekf_slam", "hymm_grid"}, config), SizeIs(1));
  EXPECT_THAT(makeStages(nodeNames(), config), SizeIs(nodeNames().size() - 1));
}

TEST(SuiteStages, RefuseConfigurationsThatCannotBeUsed) {
  SuiteConfig config;
  config.hymm_grid.map.resolution_m = 0.005;  // needs more than the memory allowed
  EXPECT_THROW(makeStages({"cekf_slam", "hymm_grid"}, config), ConfigError);
}

TEST(SuiteStages, RefuseToWriteOtherScansThanTheFilterObserves) {
  SuiteConfig config;
  config.cekf_slam.observation_input = "points";
  EXPECT_THROW(makeStages({"cekf_slam", "hymm_grid"}, config), ConfigError);
  EXPECT_NO_THROW(makeStages({"cekf_slam"}, config));
  config.hymm_grid.scan_input = "points";
  EXPECT_NO_THROW(makeStages({"cekf_slam", "hymm_grid"}, config));
  config.cekf_slam.observation_input = "detections";
  EXPECT_NO_THROW(makeStages({"cekf_slam", "hymm_grid"}, config));
}

}  // namespace
}  // namespace hymm::core
