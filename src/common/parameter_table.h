#pragma once

#include <string>

#include "common/config.h"

namespace hymm::core {

/// The unit that a parameter's name carries (`range_max_m`: "m"); empty where it carries none.
std::string unitOf(const std::string& name);

/// The admissible values of a parameter: "0 to 1", "> 0", "`scan`, `points`"; empty for any.
std::string admissibleText(const ConfigSchema::Entry& entry);

/// The value that a parameter has now: of a configuration that was not read, its default.
std::string valueText(const ConfigSchema::Entry& entry);

/// The parameters of a configuration as a Markdown table: name, unit, default, range, meaning, in
/// the order of the description. Groups are joined by slashes, as ROS names them.
std::string parameterTable(const ConfigSchema& schema);

template <class Config>
std::string parameterTable(Config defaults) {
  ConfigSchema schema;
  defaults.describe(schema);
  return parameterTable(std::as_const(schema));
}

}  // namespace hymm::core
