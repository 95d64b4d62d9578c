#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace hymm::core {

/// Admissible values of a numeric parameter, both ends included unless said otherwise.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;

  bool contains(double value) const;
  std::string text() const;

  static Range any() { return {}; }
  static Range positive() { return {0.0, std::numeric_limits<double>::infinity(), true}; }
  static Range notNegative() { return {0.0, std::numeric_limits<double>::infinity(), false}; }
  static Range between(double low, double high) { return {low, high, false}; }
};

/// The parameters of a configuration, bound to the fields that hold them. A configuration describes
/// itself once, in `void describe(ConfigSchema&)`; reading YAML, refusing bad values, suggesting
/// names and the parameter reference all come from that one description. Units stand in the names.
class ConfigSchema {
 public:
  struct Entry {
    std::string path;  ///< dotted, from the root of the configuration
    std::variant<double*, int*, bool*, std::string*> value;
    Range range;
    std::vector<std::string> choices;  ///< admissible texts; empty for any
    std::string meaning;
  };

  void number(const std::string& name, double& value, Range range, const std::string& meaning);
  void integer(const std::string& name, int& value, Range range, const std::string& meaning);
  void flag(const std::string& name, bool& value, const std::string& meaning);
  void text(const std::string& name, std::string& value, const std::string& meaning,
            std::vector<std::string> choices = {});

  /// A nested configuration, which describes itself below `name`.
  template <class Config>
  void group(const std::string& name, Config& config) {
    const std::string outer = prefix_;
    prefix_ += name + ".";
    config.describe(*this);
    prefix_ = outer;
  }

  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::string prefix_;
  std::vector<Entry> entries_;
};

/// What reading found: `errors` make a configuration unusable, `warnings` are worth telling.
struct ConfigReport {
  std::vector<std::string> errors;
  std::vector<std::string> warnings;

  /// Throws ConfigError with all errors, if there are any.
  void throwIfUnusable() const;
};

/// Overwrites the fields of the schema with what `node` holds; a missing name keeps its value. Bad
/// types and values out of range become errors, unknown names warnings with the nearest known name.
/// `origin` (a file, a ROS namespace) leads each sentence.
void readConfig(const YAML::Node& node, const ConfigSchema& schema, const std::string& origin,
                ConfigReport& report);

template <class Config>
void readConfig(const YAML::Node& node, Config& config, const std::string& origin,
                ConfigReport& report) {
  ConfigSchema schema;
  config.describe(schema);
  readConfig(node, std::as_const(schema), origin, report);
}

/// A sentence for each number that is out of its range: for configurations that code has filled.
std::vector<std::string> rangeProblems(const ConfigSchema& schema);

/// Of `names`, the one that differs from `name` by the fewest edits; empty if there are none.
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/// `overlay` over `base`: maps are merged, anything else is replaced.
YAML::Node mergeYaml(const YAML::Node& base, const YAML::Node& overlay);

}  // namespace hymm::core
