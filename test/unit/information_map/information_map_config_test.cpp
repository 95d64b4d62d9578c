#include "information_map/information_map_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/shipped_config.h"

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(InformationMapConfig, DefaultsAreUsable) {
  EXPECT_THAT(InformationMapConfig{}.problems(), IsEmpty());
}

TEST(InformationMapConfig, RefusesValuesThatEveryPlaceHas) {
  InformationMapConfig config;
  config.level_sets.values = "25 0 -3 many";
  EXPECT_THAT(config.problems(), ElementsAre(HasSubstr("0 must be greater than 0"),
                                             HasSubstr("-3 must be greater than 0"),
                                             HasSubstr("'many' is not a number")));
  config.level_sets.values = "";
  EXPECT_THAT(config.problems(), ElementsAre(HasSubstr("names no value")));
  config.level_sets.values = "25 25";
  EXPECT_THAT(config.problems(), ElementsAre(HasSubstr("twice")));
}

TEST(InformationMapConfig, ListsAllThatIsWrong) {
  InformationMapConfig config;
  config.information.sensor.range_m = -1.0;
  config.level_sets.resolution_m = 0.0;
  config.information.heading = "north";
  EXPECT_THAT(config.problems(), ElementsAre(HasSubstr("sensor.range_m"), HasSubstr("'north'"),
                                             HasSubstr("resolution_m"), HasSubstr("min_range_m")));
}

TEST(InformationMapConfig, SortsItsValues) {
  InformationMapConfig config;
  config.level_sets.values = "100 4 25";
  std::vector<std::string> problems;
  EXPECT_THAT(config.level_sets.valuesAscending(problems), ElementsAre(4.0, 25.0, 100.0));
}

TEST(InformationMapConfig, IsDocumentedByItsShippedFile) {
  test::expectDocumentedByShippedFile("information_map", InformationMapConfig());
}

}  // namespace
}  // namespace hymm::core
