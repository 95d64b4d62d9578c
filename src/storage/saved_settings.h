#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/config.h"

namespace hymm::core {

/// What a configuration said when a map was saved: values as text, by dotted name.
using SavedSettings = std::map<std::string, std::string>;

SavedSettings settingsOf(const ConfigSchema& schema);

template <class Config>
SavedSettings settingsOf(Config config) {
  ConfigSchema schema;
  config.describe(schema);
  return settingsOf(std::as_const(schema));
}

/// A text for each parameter that was different: "association.max_nodes was 1000 and is 500".
std::vector<std::string> differencesOf(const SavedSettings& saved, const SavedSettings& present);

}  // namespace hymm::core
