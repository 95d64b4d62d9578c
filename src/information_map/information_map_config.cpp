#include "information_map/information_map_config.h"

#include <algorithm>
#include <locale>
#include <sstream>

namespace hymm::core {
namespace {

constexpr std::size_t kMostLevels = 16;

std::vector<std::string> rangeProblems(const InformationMapConfig& config) {
  std::vector<std::string> problems;
  InformationMapConfig copy = config;
  ConfigSchema schema;
  copy.describe(schema);
  for (const ConfigSchema::Entry& entry : schema.entries()) {
    double value = entry.range.min;
    if (auto* const* number = std::get_if<double*>(&entry.value)) value = **number;
    if (auto* const* integer = std::get_if<int*>(&entry.value)) value = **integer;
    if (entry.value.index() < 2 && !entry.range.contains(value)) {
      std::ostringstream text;
      text << entry.path << ": is " << value << ", but must be " << entry.range.text() << ".";
      problems.push_back(text.str());
    }
    if (auto* const* choice = std::get_if<std::string*>(&entry.value)) {
      const auto& choices = entry.choices;
      if (!choices.empty() &&
          std::find(choices.begin(), choices.end(), **choice) == choices.end()) {
        problems.push_back(entry.path + ": '" + **choice + "' is not known.");
      }
    }
  }
  return problems;
}

}  // namespace

void LevelSetConfig::describe(ConfigSchema& schema) {
  schema.text("values", values,
              "of information that level sets are kept for, separated by spaces [1/m^2]; 25 stands "
              "for a deviation of 0.2 m, 100 for 0.1 m");
  schema.number("resolution_m", resolution_m, Range::positive(), "side of the smallest leaves");
  schema.number("max_cells", max_cells, Range{1.0, 1e9, false},
                "smallest leaves that the surroundings of all landmarks may hold; a map that needs "
                "more is refused");
  schema.integer("max_evaluations", max_evaluations, Range::between(100.0, 1e9),
                 "of the information after one change of the map, the vehicle's island first; what "
                 "is left is done after the next one");
  schema.text("losses", losses,
              "what becomes of places where the information fell below the value: they leave the "
              "set, or stay as long as the landmarks around have moved less than a leaf",
              {"drop", "keep"});
}

std::vector<double> LevelSetConfig::valuesAscending(std::vector<std::string>& problems) const {
  std::vector<double> ascending;
  std::istringstream words(values);
  std::string word;
  while (words >> word) {
    double value = 0.0;
    std::istringstream number(word);
    number.imbue(std::locale::classic());
    if (!(number >> value) || !number.eof()) {
      problems.push_back("level_sets.values: '" + word + "' is not a number.");
    } else if (!(value > 0.0)) {
      problems.push_back("level_sets.values: " + word +
                         " must be greater than 0: every place has at least that much.");
    } else {
      ascending.push_back(value);
    }
  }
  std::sort(ascending.begin(), ascending.end());
  if (std::adjacent_find(ascending.begin(), ascending.end()) != ascending.end()) {
    problems.emplace_back("level_sets.values: names a value twice.");
  }
  if (ascending.empty() && problems.empty()) {
    problems.emplace_back("level_sets.values: names no value.");
  }
  if (ascending.size() > kMostLevels) {
    problems.push_back("level_sets.values: names more than " + std::to_string(kMostLevels) +
                       " values.");
  }
  return ascending;
}

void ExplorationConfig::describe(ConfigSchema& schema) {
  schema.number("max_position_deviation_m", max_position_deviation_m, Range::positive(),
                "largest that is predicted anywhere on the way to a suggested goal");
  schema.number("max_heading_deviation_rad", max_heading_deviation_rad, Range::positive(),
                "largest that is predicted anywhere on the way to a suggested goal");
  schema.number("speed_mps", speed_mps, Range::positive(), "on the way to a suggested goal");
  schema.number("spacing_m", spacing_m, Range::positive(), "of goals along the border");
  schema.integer("max_suggestions", max_suggestions, Range::between(1.0, 1000.0),
                 "goals that an answer holds");
}

void InformationMapConfig::describe(ConfigSchema& schema) {
  schema.group("information", information);
  schema.group("level_sets", level_sets);
  schema.group("dense_map", dense_map);
  schema.group("exploration", exploration);
}

std::vector<std::string> InformationMapConfig::problems() const {
  std::vector<std::string> problems = rangeProblems(*this);
  level_sets.valuesAscending(problems);
  if (information.sensor.min_range_m >= information.sensor.range_m) {
    problems.emplace_back(
        "information.sensor.min_range_m: is not less than information.sensor.range_m.");
  }
  return problems;
}

}  // namespace hymm::core
