#pragma once

#include <cstdlib>
#include <string>
#include <type_traits>
#include <variant>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "common/config.h"

namespace hymm::test {

/// Expects that config/NODE.yaml holds every parameter of `defaults` with its default value.
template <class Config>
void expectDocumentedByShippedFile(const std::string& node, Config defaults) {
  const char* source = std::getenv("HYMM_SOURCE_DIR");
  ASSERT_NE(source, nullptr);
  const YAML::Node file = YAML::LoadFile(std::string(source) + "/config/" + node + ".yaml");
  core::ConfigSchema schema;
  defaults.describe(schema);
  for (const auto& entry : schema.entries()) {
    YAML::Node found = YAML::Clone(file[node]);
    std::string rest = entry.path;
    while (found && !rest.empty()) {
      const std::size_t dot = rest.find('.');
      found = YAML::Clone(found[rest.substr(0, dot)]);
      rest = dot == std::string::npos ? "" : rest.substr(dot + 1);
    }
    ASSERT_TRUE(found && found.IsScalar()) << entry.path << " is missing";
    std::visit(
        [&](const auto* value) {
          EXPECT_EQ(found.as<std::decay_t<decltype(*value)>>(), *value) << entry.path;
        },
        entry.value);
  }
}

}  // namespace hymm::test
