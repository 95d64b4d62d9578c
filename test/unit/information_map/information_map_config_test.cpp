#include "information_map/information_map_config.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

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
  const char* source = std::getenv("HYMM_SOURCE_DIR");
  ASSERT_NE(source, nullptr);
  const YAML::Node file = YAML::LoadFile(std::string(source) + "/config/information_map.yaml");
  InformationMapConfig defaults;
  ConfigSchema schema;
  defaults.describe(schema);
  for (const auto& entry : schema.entries()) {
    YAML::Node node = YAML::Clone(file["information_map"]);
    std::string rest = entry.path;
    while (node && !rest.empty()) {
      const std::size_t dot = rest.find('.');
      node = YAML::Clone(node[rest.substr(0, dot)]);
      rest = dot == std::string::npos ? "" : rest.substr(dot + 1);
    }
    ASSERT_TRUE(node && node.IsScalar()) << entry.path << " is missing";
    std::visit(
        [&](const auto* value) {
          EXPECT_EQ(node.as<std::decay_t<decltype(*value)>>(), *value) << entry.path;
        },
        entry.value);
  }
}

}  // namespace
}  // namespace hymm::core
