#include "common/parameter_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace hymm::core {
namespace {

/// What a name ends with, and the unit that it stands for. Longer endings come first.
constexpr std::array<std::pair<const char*, const char*>, 13> kUnits = {{
    {"_per_m2", "1/m²"},
    {"_cells", "cells"},
    {"_radps", "rad/s"},
    {"_mps2", "m/s²"},
    {"_mps", "m/s"},
    {"_rad", "rad"},
    {"_deg", "°"},
    {"_m2", "m²"},
    {"_hz", "Hz"},
    {"_mb", "MB"},
    {"_ms", "ms"},
    {"_m", "m"},
    {"_s", "s"},
}};

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() > ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

/// To six digits: as people write it, 3.14159 rather than all that a double holds.
std::string rounded(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string code(const std::string& text) { return "`" + text + "`"; }

std::string numberRange(const Range& range) {
  const std::string low = rounded(range.min), high = rounded(range.max);
  const bool bounded_below = std::isfinite(range.min), bounded_above = std::isfinite(range.max);
  const std::string from = (range.min_excluded ? "> " : "≥ ") + low;
  if (bounded_below && bounded_above) {
    return range.min_excluded ? from + ", ≤ " + high : low + " to " + high;
  }
  if (bounded_below) return from;
  return bounded_above ? "≤ " + high : "";
}

/// A cell of a Markdown table ends at a bar.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

std::string slashed(std::string path) {
  std::replace(path.begin(), path.end(), '.', '/');
  return path;
}

std::string textOf(double value) { return rounded(value); }
std::string textOf(int value) { return std::to_string(value); }
std::string textOf(bool value) { return value ? "true" : "false"; }
std::string textOf(const std::string& value) { return value.empty() ? "" : code(value); }

}  // namespace

std::string unitOf(const std::string& name) {
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(),
                                 [&](const auto& u) { return endsWith(name, u.first); });
  return unit == kUnits.end() ? "" : unit->second;
}

std::string admissibleText(const ConfigSchema::Entry& entry) {
  if (std::holds_alternative<bool*>(entry.value)) return "true, false";
  if (!std::holds_alternative<std::string*>(entry.value)) return numberRange(entry.range);
  std::string choices;
  for (const std::string& choice : entry.choices) {
    choices += (choices.empty() ? "" : ", ") + code(choice);
  }
  return choices;
}

std::string valueText(const ConfigSchema::Entry& entry) {
  return std::visit([](const auto* value) { return textOf(*value); }, entry.value);
}

std::string parameterTable(const ConfigSchema& schema) {
  std::string table =
      "| parameter | unit | default | range | meaning |\n"
      "|---|---|---|---|---|\n";
  for (const ConfigSchema::Entry& entry : schema.entries()) {
    table += "| " + code(slashed(entry.path)) + " | " + unitOf(entry.path) + " | " +
             escaped(valueText(entry)) + " | " + escaped(admissibleText(entry)) + " | " +
             escaped(entry.meaning) + " |\n";
  }
  return table;
}

}  // namespace hymm::core
