#include "common/json.h"

#include <limits>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

namespace hymm::core {
namespace {

TEST(Json, KeepsOrderAndNesting) {
  JsonObject inner;
  inner.add("b", 2.5);
  JsonObject json;
  json.add("z", std::size_t{3}).add("inner", inner).add("a", std::string("text"));
  EXPECT_EQ(json.text(),
            "{\n  \"z\": 3,\n  \"inner\": {\n    \"b\": 2.5\n  },\n  \"a\": \"text\"\n}");
}

TEST(Json, WritesNullWhereThereIsNoNumber) {
  JsonObject json;
  json.add("nan", std::numeric_limits<double>::quiet_NaN());
  json.add("inf", std::numeric_limits<double>::infinity());
  json.add("none", std::optional<double>());
  const YAML::Node read = YAML::Load(json.text());
  EXPECT_TRUE(read["nan"].IsNull());
  EXPECT_TRUE(read["inf"].IsNull());
  EXPECT_TRUE(read["none"].IsNull());
}

TEST(Json, EscapesWhatWouldEndAText) {
  EXPECT_EQ(jsonQuoted("a\"b\\c\nd"), "\"a\\\"b\\\\c\\u000ad\"");
}

TEST(Json, EmptyObjectsAndArraysAreValid) {
  JsonObject json;
  json.add("object", JsonObject()).add("array", std::vector<double>());
  EXPECT_EQ(json.text(), "{\n  \"object\": {},\n  \"array\": []\n}");
}

}  // namespace
}  // namespace hymm::core
