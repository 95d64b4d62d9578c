#include "common/parameter_table.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

struct Inner {
  double range_max_m = 80.0;
  int beams = 361;
  void describe(ConfigSchema& schema) {
    schema.number("range_max_m", range_max_m, Range::positive(), "farther is free | or unknown");
    schema.integer("beams", beams, Range{2.0, 1000.0}, "a scan");
  }
};

struct Outer {
  bool enabled = true;
  double share = 0.1;
  std::string input = "scan";
  std::string layers;
  Inner laser;
  void describe(ConfigSchema& schema) {
    schema.flag("enabled", enabled, "whether it runs");
    schema.number("share", share, Range{0.0, 1.0, true}, "of all");
    schema.text("input", input, "what comes", {"scan", "points"});
    schema.text("layers", layers, "further ones");
    schema.group("laser", laser);
  }
};

TEST(ParameterTable, TellsUnitDefaultRangeAndMeaningOfEachParameter) {
  EXPECT_EQ(parameterTable(Outer{}),
            "| parameter | unit | default | range | meaning |\n"
            "|---|---|---|---|---|\n"
            "| `enabled` |  | true | true, false | whether it runs |\n"
            "| `share` |  | 0.1 | > 0, ≤ 1 | of all |\n"
            "| `input` |  | `scan` | `scan`, `points` | what comes |\n"
            "| `layers` |  |  |  | further ones |\n"
            "| `laser/range_max_m` | m | 80 | > 0 | farther is free \\| or unknown |\n"
            "| `laser/beams` |  | 361 | 2 to 1000 | a scan |\n");
}

TEST(ParameterTable, TellsValuesThatOthersSet) {
  Outer changed;
  changed.laser.beams = 720;
  EXPECT_NE(parameterTable(changed).find("| 720 | 2 to 1000 |"), std::string::npos);
}

TEST(ParameterTable, ReadsUnitsFromTheEndOfNames) {
  EXPECT_EQ(unitOf("noise.speed_deviation_mps"), "m/s");
  EXPECT_EQ(unitOf("acceleration_mps2"), "m/s²");
  EXPECT_EQ(unitOf("unmapped_density_per_m2"), "1/m²");
  EXPECT_EQ(unitOf("steering_rate_radps"), "rad/s");
  EXPECT_EQ(unitOf("motion_wait_s"), "s");
  EXPECT_EQ(unitOf("max_nodes"), "");
  EXPECT_EQ(unitOf("beams"), "") << "an s without an underscore is a plural";
}

}  // namespace
}  // namespace hymm::core
