#include "door_planner/door_planner_config.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>

namespace hymm::core {
namespace {

constexpr const char* kForms =
    "NAME WEIGHT, NAME climb WEIGHT, NAME one_way WEIGHT or NAME forbidden THRESHOLD with a number "
    "that is not negative, and a weight of at most 1e9";

/// One entry; false if it is none.
bool readWeight(const std::string& entry, PropertyWeight& weight) {
  using Kind = PropertyWeight::Kind;
  static const std::map<std::string, Kind> kKinds{
      {"climb", Kind::kClimb}, {"one_way", Kind::kOneWay}, {"forbidden", Kind::kForbidden}};
  std::istringstream words(entry);
  std::string word;
  if (!(words >> weight.property >> word)) return false;
  const auto kind = kKinds.find(word);
  if (kind != kKinds.end()) {
    weight.kind = kind->second;
    if (!(words >> word)) return false;
  }
  std::istringstream number(word);
  const bool is_number = static_cast<bool>(number >> weight.weight) && number.eof();
  const bool is_usable = weight.isDirected() || weight.property.find('>') == std::string::npos;
  const double most = weight.kind == Kind::kForbidden ? std::numeric_limits<float>::max()
                                                      : PathCostConfig::kDearest;
  return is_number && !(words >> word) && weight.weight >= 0.0 && weight.weight <= most &&
         is_usable;
}

/// Calls `visit(entry)` for what semicolons part, but for what is blank.
template <class Visitor>
void visitEntries(const std::string& text, Visitor&& visit) {
  std::istringstream entries(text);
  std::string entry;
  while (std::getline(entries, entry, ';')) {
    if (entry.find_first_not_of(" \t") != std::string::npos) visit(entry);
  }
}

}  // namespace

void PathCostConfig::describe(ConfigSchema& schema) {
  schema.number("distance", distance, Range::between(0.0, kDearest),
                "of a metre, wherever it lies");
  schema.number("occupancy", occupancy, Range::between(0.0, kDearest),
                "of a metre, times the probability that it is occupied");
  schema.number("occupied_probability", occupied_probability, Range::between(0.05, 0.99),
                "from which nothing passes");
  schema.number("probability_step", probability_step, Range{0.0, 0.3, false},
                "to which probabilities are rounded, so that small changes need no new costs");
  schema.number("unknown", unknown, Range::between(0.0, kDearest),
                "of a metre in addition where the occupancy is not known");
  schema.flag("unknown_is_occupied", unknown_is_occupied, "nothing passes where it is not known");
  schema.text(
      "properties", properties,
      "cost of further layers, as 'NAME WEIGHT; NAME climb WEIGHT; NAME one_way WEIGHT; NAME "
      "forbidden THRESHOLD': of a metre times the layer's value, of each unit that it rises, "
      "or falls, or no passing from that value on; a category is named LAYER.CATEGORY, going "
      "from A to B, which falls the other way, LAYER.A>B");
}

std::optional<std::pair<std::string, std::string>> PropertyWeight::categories() const {
  const std::size_t arrow = property.find('>'), dot = property.find('.');
  if (arrow == std::string::npos || dot == std::string::npos || dot > arrow) return std::nullopt;
  return std::make_pair(property.substr(0, arrow),
                        property.substr(0, dot + 1) + property.substr(arrow + 1));
}

std::vector<PropertyWeight> PathCostConfig::weights(std::vector<std::string>& problems) const {
  std::vector<PropertyWeight> weights;
  visitEntries(properties, [&](const std::string& entry) {
    PropertyWeight weight;
    if (readWeight(entry, weight)) {
      weights.push_back(weight);
    } else {
      problems.push_back("cost.properties: '" + entry + "' is not " + kForms + ".");
    }
  });
  return weights;
}

PathCostConfig PathCostConfig::with(const std::string& text,
                                    std::vector<std::string>& problems) const {
  PathCostConfig made = *this;
  std::map<std::string, double*> own{
      {"distance", &made.distance}, {"occupancy", &made.occupancy}, {"unknown", &made.unknown}};
  std::set<std::string> named;
  std::string added;
  visitEntries(text, [&](const std::string& entry) {
    PropertyWeight weight;
    if (!readWeight(entry, weight)) {
      problems.push_back("weights: '" + entry + "' is not " + kForms + ".");
    } else if (own.count(weight.property) > 0 && weight.kind == PropertyWeight::Kind::kPerMetre) {
      *own[weight.property] = weight.weight;
    } else {
      named.insert(weight.property);
      added += entry + ";";
    }
  });
  made.properties.clear();
  visitEntries(properties, [&](const std::string& entry) {
    PropertyWeight weight;
    if (readWeight(entry, weight) && named.count(weight.property) == 0) {
      made.properties += entry + ";";
    }
  });
  made.properties += added;
  return made;
}

void PlannedVehicleConfig::describe(ConfigSchema& schema) {
  schema.number("width_m", width_m, Range::positive(), "of the widest part of the vehicle");
  schema.number("length_m", length_m, Range::positive(), "from end to end");
  schema.number("rear_overhang_m", rear_overhang_m, Range::notNegative(),
                "of what lies behind base_link");
  schema.number("turning_radius_m", turning_radius_m, Range::positive(),
                "the smallest, of base_link");
  schema.flag("can_reverse", can_reverse,
              "refined paths may go backwards (Reeds-Shepp), else not (Dubins)");
}

void RefinementConfig::describe(ConfigSchema& schema) {
  schema.flag("enabled", enabled, "paths are refined for the turning radius, where that succeeds");
  schema.integer("iterations", iterations, Range::between(0.0, 1e6),
                 "of the search by RRT* in all of a path, where simple curves are blocked");
  schema.number("step_m", step_m, Range{0.05, 2.0, false},
                "between poses of a refined path, at most; so often it is checked");
  schema.number("direction_change_m", direction_change_m, Range::notNegative(),
                "of cheapest ground, what a change of direction costs");
  schema.integer("seed", seed, Range::between(0.0, 2147483647.0), "of the search");
}

void DoorPlannerConfig::describe(ConfigSchema& schema) {
  schema.group("footprint", vehicle);
  schema.group("cost", cost);
  schema.group("refinement", refinement);
  schema.number("portal_spacing_m", portal_spacing_m, Range{0.2, 50.0, false},
                "largest distance of portals on a side; a quarter of the side if that is less");
  schema.number("district_m", district_m, Range::notNegative(),
                "edge of the squares of map whose LTRs long ways cross at once; 0: each by itself");
  schema.number("max_metric_error", max_metric_error, Range{0.001, 0.1, false},
                "share by which a path along cells is longer than a straight one, at worst");
  schema.number("shape_tolerance", shape_tolerance, Range{0.0001, 0.2, false},
                "share by which a length in an LTR may change before its costs are computed anew");
  schema.number("landmark_diameter_m", landmark_diameter_m, Range::notNegative(),
                "of a landmark whose diameter is not told: each is a solid disc");
  schema.flag("outside_is_occupied", outside_is_occupied,
              "the vehicle's disc stays within the LTRs, beyond which the planner knows nothing; "
              "else it may reach beyond them, where only landmarks are avoided");
  schema.number("tolerance_m", tolerance_m, Range{0.0, 100.0, false},
                "by which start and goal are moved if they are occupied, where a request does not "
                "say");
  schema.number("time_limit_s", time_limit_s, Range::positive(),
                "of a request, by the wall; offline there is none");
  schema.text("goal", goal,
              "'X Y' in map [m]: hymm_offline plans there from the last pose and writes plan.csv; "
              "empty for none");
  schema.integer("check_queries", check_queries, Range::between(0.0, 1e6),
                 "random queries that hymm_offline plans at the end, checks against the dense map, "
                 "and lists in plan_queries.csv");
}

std::optional<Eigen::Vector2d> DoorPlannerConfig::goalPlace() const {
  std::istringstream words(goal);
  Eigen::Vector2d place;
  std::string rest;
  if (!(words >> place.x() >> place.y()) || words >> rest || !place.allFinite())
    return std::nullopt;
  return place;
}

std::vector<std::string> DoorPlannerConfig::problems() const {
  std::vector<std::string> problems;
  DoorPlannerConfig copy = *this;
  ConfigSchema schema;
  copy.describe(schema);
  for (const ConfigSchema::Entry& entry : schema.entries()) {
    const auto* const* number = std::get_if<double*>(&entry.value);
    if (number == nullptr || entry.range.contains(**number)) continue;
    std::ostringstream text;
    text << entry.path << ": is " << **number << ", but must be " << entry.range.text() << ".";
    problems.push_back(text.str());
  }
  cost.weights(problems);
  if (!goal.empty() && !goalPlace()) {
    problems.push_back("goal: '" + goal + "' is not two numbers, X and Y in map [m].");
  }
  if (cost.distance >= 0.0 && cost.distance < PathCostConfig::kCheapest) {
    std::ostringstream text;
    text << "cost.distance: is " << cost.distance
         << ", so that going round in circles on free ground would cost nothing; give it at least "
         << PathCostConfig::kCheapest << ".";
    problems.push_back(text.str());
  }
  if (vehicle.rear_overhang_m > vehicle.length_m) {
    problems.emplace_back("footprint.rear_overhang_m: is greater than footprint.length_m.");
  }
  return problems;
}

}  // namespace hymm::core
