#include "common/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct WheelConfig {
  double radius_m = 0.3;

  void describe(ConfigSchema& schema) {
    schema.number("radius_m", radius_m, Range::positive(), "of the tyre");
  }
};

struct CartConfig {
  double speed_mps = 1.0;
  double share = 0.5;
  int seats = 2;
  bool lights = false;
  std::string name = "cart";
  std::string drive = "rear";
  WheelConfig wheel;

  void describe(ConfigSchema& schema) {
    schema.number("speed_mps", speed_mps, Range::notNegative(), "when nobody pushes");
    schema.number("share", share, Range::between(0.0, 1.0), "of the load in front");
    schema.integer("seats", seats, Range::between(1, 4), "for people");
    schema.flag("lights", lights, "switched on");
    schema.text("name", name, "for people");
    schema.text("drive", drive, "driven axle", {"front", "rear"});
    schema.group("wheel", wheel);
  }
};

ConfigReport read(const std::string& yaml, CartConfig& config) {
  ConfigReport report;
  readConfig(YAML::Load(yaml), config, "cart.yaml", report);
  return report;
}

/// The only error that reading `yaml` gives; nothing if there are none or several.
std::string errorOf(const std::string& yaml) {
  CartConfig config;
  const ConfigReport report = read(yaml, config);
  EXPECT_EQ(report.errors.size(), 1U) << yaml;
  return report.errors.size() == 1 ? report.errors.front() : "";
}

TEST(ReadConfig, ReadsEveryTypeAndNestedGroups) {
  CartConfig config;
  const ConfigReport report = read(
      "{speed_mps: 2.5, share: 1, seats: 4, lights: true, name: 'my cart', drive: front,"
      " wheel: {radius_m: 0.25}}",
      config);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_THAT(report.warnings, IsEmpty());
  EXPECT_EQ(config.speed_mps, 2.5);
  EXPECT_EQ(config.share, 1.0);
  EXPECT_EQ(config.seats, 4);
  EXPECT_TRUE(config.lights);
  EXPECT_EQ(config.name, "my cart");
  EXPECT_EQ(config.drive, "front");
  EXPECT_EQ(config.wheel.radius_m, 0.25);
}

TEST(ReadConfig, KeepsWhatIsNotNamed) {
  CartConfig config;
  config.seats = 3;
  EXPECT_THAT(read("{speed_mps: 2.0, wheel: {}}", config).errors, IsEmpty());
  EXPECT_EQ(config.seats, 3);
  EXPECT_EQ(config.wheel.radius_m, 0.3);
  EXPECT_THAT(read("", config).errors, IsEmpty());
  EXPECT_EQ(config.speed_mps, 2.0);
}

TEST(ReadConfig, RefusesNumbersThatAreNone) {
  EXPECT_EQ(errorOf("speed_mps: fast"),
            "cart.yaml: speed_mps should be a finite number, but is 'fast'.");
  EXPECT_EQ(errorOf("speed_mps: .nan"),
            "cart.yaml: speed_mps should be a finite number, but is '.nan'.");
  EXPECT_EQ(errorOf("speed_mps: .inf"),
            "cart.yaml: speed_mps should be a finite number, but is '.inf'.");
  EXPECT_EQ(errorOf("speed_mps: [1, 2]"),
            "cart.yaml: speed_mps should be a finite number, but is a list.");
  EXPECT_EQ(errorOf("speed_mps:"), "cart.yaml: speed_mps should be a finite number, but is empty.");
}

TEST(ReadConfig, RefusesFractionsForWholeNumbers) {
  EXPECT_EQ(errorOf("seats: 2.5"), "cart.yaml: seats should be a whole number, but is '2.5'.");
  EXPECT_EQ(errorOf("seats: two"), "cart.yaml: seats should be a whole number, but is 'two'.");
}

TEST(ReadConfig, RefusesFlagsAndTextsOfAnotherType) {
  EXPECT_EQ(errorOf("lights: 7"), "cart.yaml: lights should be true or false, but is '7'.");
  EXPECT_EQ(errorOf("name: {first: a}"), "cart.yaml: name should be a text, but is a group.");
}

TEST(ReadConfig, RefusesValuesOutOfRangeAndSaysTheRange) {
  EXPECT_EQ(errorOf("speed_mps: -0.1"), "cart.yaml: speed_mps is -0.1, but must be at least 0.");
  EXPECT_EQ(errorOf("share: 1.01"),
            "cart.yaml: share is 1.01, but must be at least 0 and at most 1.");
  EXPECT_EQ(errorOf("seats: 5"), "cart.yaml: seats is 5, but must be at least 1 and at most 4.");
  EXPECT_EQ(errorOf("wheel: {radius_m: 0}"),
            "cart.yaml: wheel.radius_m is 0, but must be greater than 0.");
  EXPECT_EQ(errorOf("drive: all"),
            "cart.yaml: drive is 'all', but must be one of 'front', 'rear'.");
}

TEST(ReadConfig, RefusesAValueWhereAGroupShouldBe) {
  EXPECT_EQ(errorOf("wheel: 3"), "cart.yaml: wheel should be a group of parameters, but is '3'.");
  EXPECT_EQ(errorOf("just a text"),
            "cart.yaml: the configuration should be a group of parameters, but is 'just a text'.");
  EXPECT_EQ(errorOf("[1, 2]"),
            "cart.yaml: the configuration should be a group of parameters, but is a list.");
}

TEST(ReadConfig, RefusesNamesThatAreNoTexts) {
  EXPECT_EQ(errorOf("wheel: {[1, 2]: 3}"), "cart.yaml: wheel.? has a name that is a list.");
}

TEST(ReadConfig, KeepsTheOldValueOfWhatItRefuses) {
  CartConfig config;
  read("{speed_mps: -1, seats: 9, drive: all, lights: 7, name: [], wheel: {radius_m: -1}}", config);
  EXPECT_EQ(config.speed_mps, 1.0);
  EXPECT_EQ(config.seats, 2);
  EXPECT_EQ(config.drive, "rear");
  EXPECT_FALSE(config.lights);
  EXPECT_EQ(config.name, "cart");
  EXPECT_EQ(config.wheel.radius_m, 0.3);
}

TEST(ReadConfig, ListsEveryErrorAtOnce) {
  CartConfig config;
  const ConfigReport report = read("{speed_mps: -1, seats: 9, wheel: {radius_m: -1}}", config);
  EXPECT_EQ(report.errors.size(), 3U);
  try {
    report.throwIfUnusable();
    FAIL() << "no exception";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.problems(), report.errors);
    for (const std::string& problem : report.errors) {
      EXPECT_THAT(error.what(), testing::HasSubstr(problem));
    }
  }
}

TEST(ReadConfig, WarnsOfUnknownNamesWithTheNearestKnownOne) {
  CartConfig config;
  const ConfigReport report = read("{sped_mps: 3, wheel: {radius: 0.2}}", config);
  EXPECT_THAT(report.errors, IsEmpty());
  EXPECT_NO_THROW(report.throwIfUnusable());
  EXPECT_THAT(
      report.warnings,
      ElementsAre("cart.yaml: unknown parameter 'sped_mps' is ignored; did you mean 'speed_mps'?",
                  "cart.yaml: unknown parameter 'wheel.radius' is ignored; did you mean "
                  "'wheel.radius_m'?"));
  EXPECT_EQ(config.speed_mps, 1.0);
}

TEST(NearestName, CountsEdits) {
  const std::vector<std::string> names = {"range_min_m", "range_max_m", "rate_hz"};
  EXPECT_EQ(nearestName("range_mx_m", names), "range_max_m");    // one missing
  EXPECT_EQ(nearestName("ranges_min_m", names), "range_min_m");  // one too many
  EXPECT_EQ(nearestName("rate_gz", names), "rate_hz");           // one replaced
  EXPECT_EQ(nearestName("rate_hz", names), "rate_hz");
  EXPECT_EQ(nearestName("anything", {}), "");
}

TEST(Range, SaysItsBounds) {
  EXPECT_EQ(Range::any().text(), "any number");
  EXPECT_EQ(Range::positive().text(), "greater than 0");
  EXPECT_EQ(Range::notNegative().text(), "at least 0");
  EXPECT_EQ(Range::between(-1.0, 2.5).text(), "at least -1 and at most 2.5");
}

TEST(Range, IncludesItsEndsUnlessExcluded) {
  EXPECT_TRUE(Range::between(1.0, 2.0).contains(1.0));
  EXPECT_TRUE(Range::between(1.0, 2.0).contains(2.0));
  EXPECT_TRUE(Range::notNegative().contains(0.0));
  EXPECT_FALSE(Range::positive().contains(0.0));
  EXPECT_FALSE(Range::between(1.0, 2.0).contains(2.0 + 1e-12));
}

TEST(MergeYaml, MergesGroupsAndReplacesValues) {
  const YAML::Node merged = mergeYaml(YAML::Load("{a: {x: 1, y: [1, 2]}, b: 2}"),
                                      YAML::Load("{a: {y: [3], z: 4}, c: 5}"));
  EXPECT_EQ(merged["a"]["x"].as<int>(), 1);
  EXPECT_THAT(merged["a"]["y"].as<std::vector<int>>(), ElementsAre(3));
  EXPECT_EQ(merged["a"]["z"].as<int>(), 4);
  EXPECT_EQ(merged["b"].as<int>(), 2);
  EXPECT_EQ(merged["c"].as<int>(), 5);
}

TEST(MergeYaml, LeavesItsInputsAlone) {
  const YAML::Node base = YAML::Load("{a: {x: 1}}"), overlay = YAML::Load("{a: {x: 2}}");
  YAML::Node merged = mergeYaml(base, overlay);
  merged["a"]["x"] = 3;
  EXPECT_EQ(base["a"]["x"].as<int>(), 1);
  EXPECT_EQ(overlay["a"]["x"].as<int>(), 2);
}

TEST(MergeYaml, TakesTheOneThatIsThere) {
  EXPECT_EQ(mergeYaml(YAML::Load("{a: 1}"), YAML::Node())["a"].as<int>(), 1);
  EXPECT_EQ(mergeYaml(YAML::Node(), YAML::Load("{a: 1}"))["a"].as<int>(), 1);
}

}  // namespace
}  // namespace hymm::core
