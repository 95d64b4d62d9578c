#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "common/parameter_table.h"
#include "nodes/playback_config.h"
#include "nodes/recorder_config.h"
#include "nodes/saved_map_config.h"
#include "pipeline/suite_config.h"
#include "simulation/simulation_config.h"

namespace hymm {
namespace {

/// One group of parameters, as YAML has it at the top level.
struct Section {
  std::string name;
  std::string introduction;
  std::string table;
};

std::string ofNode(const std::string& name) {
  return "Private parameters of the node `" + name + "`, shipped as [config/" + name +
         ".yaml](../config/" + name + ".yaml).";
}

std::vector<Section> sections() {
  const core::SuiteConfig suite;
  const auto table = [](const auto& config) { return core::parameterTable(config); };
  return {
      {"vehicle",
       "Of the vehicle, for all nodes: a group beside theirs, or the name of a file of "
       "`config/vehicles`.",
       table(suite.vehicle)},
      {"point_clouds", "How clouds become scans, for `cekf_slam` and `hymm_grid`: beside theirs.",
       table(suite.point_clouds)},
      {"cekf_slam", ofNode("cekf_slam"), table(suite.cekf_slam)},
      {"hymm_grid", ofNode("hymm_grid"), table(suite.hymm_grid)},
      {"information_map", ofNode("information_map"), table(suite.information_map)},
      {"door_planner", ofNode("door_planner"), table(suite.door_planner)},
      {"relocaliser", ofNode("relocaliser"), table(suite.relocaliser)},
      {"supervisor", ofNode("supervisor"), table(suite.supervisor)},
      {"saved_map",
       "A map to begin with, for `supervisor`: beside its own. `map:=`, `localise_only:=` and "
       "`map_pose:=` of the launch files set them.",
       table(SavedMapConfig())},
      {"dead_reckoning", ofNode("dead_reckoning"), table(suite.dead_reckoning)},
      {"recorder", "Private parameters of the node `recorder`, which `output:=` starts.",
       table(RecorderConfig())},
      {"playback", "Private parameters of the node `playback`, which `playback.launch` starts.",
       table(PlaybackConfig())},
      {"simulation", "What `simulate_world --config` reads. No node does.",
       table(core::SimulationConfig())},
  };
}

std::string textOf(const Section& section) {
  return "## " + section.name + "\n" + section.introduction + "\n\n" + section.table;
}

std::string page() {
  std::string text =
      "# Parameters\n\n"
      "Generated from the code by `rosrun hymm hymm_parameters --output doc/parameters.md`; a unit "
      "test compares it.\n\n"
      "Each section is a group at the top level of a YAML file; a slash stands for a nested group, "
      "as in the names of ROS's\n"
      "parameters. Units stand in the names; what has none is a pure number. A configuration holds "
      "only what differs from the "
      "defaults; see\n"
      "[conventions](conventions.md#parameters) for how files apply over each other.\n";
  for (const Section& section : sections()) text += "\n" + textOf(section);
  return text;
}

std::string sectionText(const std::string& name) {
  std::vector<std::string> names;
  for (const Section& section : sections()) {
    if (section.name == name) return textOf(section);
    names.push_back(section.name);
  }
  throw core::InputError("--only " + name + ": there are no such parameters; did you mean '" +
                         core::nearestName(name, names) + "'?");
}

void write(const std::string& file, const std::string& text) {
  std::ofstream stream(file);
  stream << text;
  stream.close();
  if (!stream) throw core::OutputError(file + " cannot be written.");
}

/// Throws InputError with the first line that differs.
void check(const std::string& file, const std::string& text) {
  std::ifstream stream(file);
  if (!stream) throw core::InputError(file + " cannot be read.");
  std::istringstream expected(text);
  std::string found_line, line;
  for (int number = 1;; ++number) {
    const bool more = static_cast<bool>(std::getline(expected, line));
    const bool found = static_cast<bool>(std::getline(stream, found_line));
    if (!more && !found) return;
    if (more == found && line == found_line) continue;
    throw core::InputError(file + ", line " + std::to_string(number) +
                           " is not what the code says. It should be\n  " +
                           (more ? line : "the end") +
                           "\nWrite it anew: rosrun hymm hymm_parameters --output " + file);
  }
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  CLI::App app("Tells every parameter with its unit, default, range and meaning, as Markdown.");
  std::string only, output, checked;
  app.add_option("--only", only, "one group alone, for instance cekf_slam or vehicle");
  app.add_option("--output", output, "file to write; default: print");
  app.add_option("--check", checked, "file to compare: fails where it differs");
  CLI11_PARSE(app, argc, argv);
  try {
    const std::string text = only.empty() ? hymm::page() : hymm::sectionText(only);
    if (!checked.empty()) {
      hymm::check(checked, text);
    } else if (!output.empty()) {
      hymm::write(output, text);
    } else {
      std::cout << text;
    }
  } catch (const std::exception& error) {
    std::cerr << "hymm_parameters: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
