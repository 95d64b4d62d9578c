#include "common/config.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>

#include "common/error.h"

namespace hymm::core {
namespace {

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

std::string quotedList(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "'" : ", '") + word + "'";
  return list;
}

std::string scalarText(const YAML::Node& node) {
  if (node.IsScalar()) return "'" + node.Scalar() + "'";
  return node.IsSequence() ? "a list" : node.IsMap() ? "a group" : "empty";
}

/// Reads entries of a schema out of a YAML tree and collects what is wrong with it.
class ConfigReader {
 public:
  ConfigReader(const ConfigSchema& schema, std::string origin, ConfigReport& report)
      : schema_(schema), origin_(std::move(origin)), report_(report) {}

  void readMap(const YAML::Node& node, const std::string& prefix) {
    if (!node || node.IsNull()) return;
    if (!node.IsMap()) {
      fail(prefix.empty() ? "the configuration" : prefix.substr(0, prefix.size() - 1),
           "should be a group of parameters, but is " + scalarText(node));
      return;
    }
    for (const auto& item : node) {
      if (item.first.IsScalar()) {
        readItem(prefix + item.first.Scalar(), item.second);
      } else {
        fail(prefix + "?", "has a name that is " + scalarText(item.first));
      }
    }
  }

 private:
  void readItem(const std::string& path, const YAML::Node& node) {
    const auto& entries = schema_.entries();
    const auto entry =
        std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.path == path; });
    if (entry != entries.end()) {
      std::visit([&](auto* value) { readValue(*entry, node, *value); }, entry->value);
    } else if (isGroup(path)) {
      readMap(node, path + ".");
    } else {
      warnUnknown(path);
    }
  }

  bool isGroup(const std::string& path) const {
    const auto& entries = schema_.entries();
    return std::any_of(entries.begin(), entries.end(),
                       [&](const auto& e) { return e.path.rfind(path + ".", 0) == 0; });
  }

  void readValue(const ConfigSchema::Entry& entry, const YAML::Node& node, double& value) {
    double read = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) || !std::isfinite(read)) {
      fail(entry.path, "should be a finite number, but is " + scalarText(node));
    } else if (!entry.range.contains(read)) {
      fail(entry.path, "is " + node.Scalar() + ", but must be " + entry.range.text());
    } else {
      value = read;
    }
  }

  void readValue(const ConfigSchema::Entry& entry, const YAML::Node& node, int& value) {
    int read = 0;
    if (!node.IsScalar() || !YAML::convert<int>::decode(node, read)) {
      fail(entry.path, "should be a whole number, but is " + scalarText(node));
    } else if (!entry.range.contains(read)) {
      fail(entry.path, "is " + node.Scalar() + ", but must be " + entry.range.text());
    } else {
      value = read;
    }
  }

  void readValue(const ConfigSchema::Entry& entry, const YAML::Node& node, bool& value) {
    bool read = false;
    if (!node.IsScalar() || !YAML::convert<bool>::decode(node, read)) {
      fail(entry.path, "should be true or false, but is " + scalarText(node));
    } else {
      value = read;
    }
  }

  void readValue(const ConfigSchema::Entry& entry, const YAML::Node& node, std::string& value) {
    if (!node.IsScalar()) {
      fail(entry.path, "should be a text, but is " + scalarText(node));
      return;
    }
    const std::string read = node.Scalar();
    const auto& choices = entry.choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), read) == choices.end()) {
      fail(entry.path, "is '" + read + "', but must be one of " + quotedList(choices));
    } else {
      value = read;
    }
  }

  void fail(const std::string& path, const std::string& problem) {
    report_.errors.push_back(origin_ + ": " + path + " " + problem + ".");
  }

  void warnUnknown(const std::string& path) {
    std::vector<std::string> known;
    for (const auto& entry : schema_.entries()) {
      known.push_back(entry.path);
      for (std::size_t dot = entry.path.find('.'); dot != std::string::npos;
           dot = entry.path.find('.', dot + 1)) {
        known.push_back(entry.path.substr(0, dot));  // a group
      }
    }
    std::string sentence = origin_ + ": unknown parameter '" + path + "' is ignored";
    const std::string nearest = nearestName(path, known);
    if (!nearest.empty()) sentence += "; did you mean '" + nearest + "'?";
    report_.warnings.push_back(sentence);
  }

  const ConfigSchema& schema_;
  std::string origin_;
  ConfigReport& report_;
};

}  // namespace

std::vector<std::string> rangeProblems(const ConfigSchema& schema) {
  std::vector<std::string> problems;
  for (const ConfigSchema::Entry& entry : schema.entries()) {
    std::optional<double> value;
    if (auto* const* number = std::get_if<double*>(&entry.value)) value = **number;
    if (auto* const* integer = std::get_if<int*>(&entry.value)) value = **integer;
    if (!value || (std::isfinite(*value) && entry.range.contains(*value))) continue;
    std::ostringstream text;
    text << entry.path << ": is " << *value << ", but must be " << entry.range.text() << ".";
    problems.push_back(text.str());
  }
  return problems;
}

bool Range::contains(double value) const {
  return (min_excluded ? value > min : value >= min) && value <= max;
}

std::string Range::text() const {
  std::ostringstream stream;
  const bool bounded_below = std::isfinite(min), bounded_above = std::isfinite(max);
  if (bounded_below) stream << (min_excluded ? "greater than " : "at least ") << min;
  if (bounded_below && bounded_above) stream << " and ";
  if (bounded_above) stream << "at most " << max;
  return bounded_below || bounded_above ? stream.str() : "any number";
}

void ConfigSchema::number(const std::string& name, double& value, Range range,
                          const std::string& meaning) {
  entries_.push_back({prefix_ + name, &value, range, {}, meaning});
}

void ConfigSchema::integer(const std::string& name, int& value, Range range,
                           const std::string& meaning) {
  entries_.push_back({prefix_ + name, &value, range, {}, meaning});
}

void ConfigSchema::flag(const std::string& name, bool& value, const std::string& meaning) {
  entries_.push_back({prefix_ + name, &value, {}, {}, meaning});
}

void ConfigSchema::text(const std::string& name, std::string& value, const std::string& meaning,
                        std::vector<std::string> choices) {
  entries_.push_back({prefix_ + name, &value, {}, std::move(choices), meaning});
}

void ConfigReport::throwIfUnusable() const {
  if (!errors.empty()) throw ConfigError(errors);
}

void readConfig(const YAML::Node& node, const ConfigSchema& schema, const std::string& origin,
                ConfigReport& report) {
  ConfigReader(schema, origin, report).readMap(node, "");
}

std::string nearestName(const std::string& name, const std::vector<std::string>& names) {
  const auto nearest = std::min_element(
      names.begin(), names.end(),
      [&](const auto& a, const auto& b) { return editDistance(name, a) < editDistance(name, b); });
  return nearest == names.end() ? "" : *nearest;
}

YAML::Node mergeYaml(const YAML::Node& base, const YAML::Node& overlay) {
  if (!overlay || overlay.IsNull()) return YAML::Clone(base);
  if (!base || !base.IsMap() || !overlay.IsMap()) return YAML::Clone(overlay);
  YAML::Node merged = YAML::Clone(base);
  for (const auto& item : overlay) {
    const std::string key = item.first.as<std::string>();
    merged[key] = merged[key] ? mergeYaml(merged[key], item.second) : YAML::Clone(item.second);
  }
  return merged;
}

}  // namespace hymm::core
