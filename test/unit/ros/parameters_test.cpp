#include "ros/parameters.h"

#include <gmock/gmock.h>

namespace hymm {
namespace {

using ::testing::HasSubstr;

struct Inner {
  double length_m = 1.0;
  int count = 2;
  void describe(core::ConfigSchema& schema) {
    schema.number("length_m", length_m, core::Range::positive(), "a length");
    schema.integer("count", count, core::Range::between(0, 10), "a count");
  }
};

struct Outer {
  bool flag = false;
  std::string mode = "odom";
  Inner inner;
  void describe(core::ConfigSchema& schema) {
    schema.flag("flag", flag, "a flag");
    schema.text("mode", mode, "a choice", {"odom", "dead_reckoning"});
    schema.group("inner", inner);
  }
};

core::ConfigReport read(const XmlRpc::XmlRpcValue& tree, Outer& config) {
  core::ConfigReport report;
  core::readConfig(toYaml(tree), config, "/node", report);
  return report;
}

TEST(Parameters, EveryTypeArrivesWithAllItsDigits) {
  XmlRpc::XmlRpcValue tree;
  tree["flag"] = true;
  tree["mode"] = std::string("dead_reckoning");
  tree["inner"]["length_m"] = 0.1 + 0.2;
  tree["inner"]["count"] = 7;
  Outer config;
  const core::ConfigReport report = read(tree, config);
  EXPECT_TRUE(report.errors.empty());
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_TRUE(config.flag);
  EXPECT_EQ(config.mode, "dead_reckoning");
  EXPECT_EQ(config.inner.length_m, 0.1 + 0.2);
  EXPECT_EQ(config.inner.count, 7);
}

TEST(Parameters, WholeNumberIsANumberToo) {
  XmlRpc::XmlRpcValue tree;
  tree["inner"]["length_m"] = 3;
  Outer config;
  EXPECT_TRUE(read(tree, config).errors.empty());
  EXPECT_EQ(config.inner.length_m, 3.0);
}

TEST(Parameters, AllBadValuesAreListed) {
  XmlRpc::XmlRpcValue tree;
  tree["mode"] = std::string("wheels");
  tree["inner"]["length_m"] = -1.0;
  tree["inner"]["count"] = 11;
  Outer config;
  const core::ConfigReport report = read(tree, config);
  ASSERT_EQ(report.errors.size(), 3U);
  EXPECT_THAT(report.errors, ::testing::Contains(HasSubstr("mode")));
  EXPECT_THAT(report.errors, ::testing::Contains(HasSubstr("inner.length_m")));
  EXPECT_THAT(report.errors, ::testing::Contains(HasSubstr("inner.count")));
}

TEST(Parameters, UnknownNameGetsTheNearestKnownOne) {
  XmlRpc::XmlRpcValue tree;
  tree["inner"]["lenght_m"] = 1.0;
  Outer config;
  const core::ConfigReport report = read(tree, config);
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_THAT(report.warnings[0], HasSubstr("'inner.length_m'"));
}

}  // namespace
}  // namespace hymm
