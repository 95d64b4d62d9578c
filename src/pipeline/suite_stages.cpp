#include "pipeline/suite_stages.h"

#include <algorithm>

#include "common/error.h"
#include "pipeline/door_stage.h"
#include "pipeline/grid_stage.h"
#include "pipeline/information_stage.h"
#include "pipeline/relocaliser_stage.h"
#include "pipeline/supervisor_stage.h"

namespace hymm::core {
namespace {

constexpr const char* kFilter = "cekf_slam";

struct StageKind {
  const char* name;
  std::unique_ptr<SuiteStage> (*make)(const SuiteConfig&);
};

/// Live, scans of another topic than the filter's would find no pose.
void refuseOtherScans(const SuiteConfig& config) {
  const std::string& observations = config.cekf_slam.observation_input;
  const std::string& scans = config.hymm_grid.scan_input;
  if (observations == "detections" || observations == scans) return;
  throw ConfigError({"hymm_grid.scan_input: is " + scans + ", but cekf_slam.observation_input is " +
                     observations +
                     "; the dense map can only write what the filter observed. Set it to " +
                     observations + "."});
}

const std::vector<StageKind>& stageKinds() {
  static const std::vector<StageKind> kinds = {
      {GridStage::kName,
       [](const SuiteConfig& config) -> std::unique_ptr<SuiteStage> {
         refuseOtherScans(config);
         return std::make_unique<GridStage>(config.hymm_grid);
       }},
      {InformationStage::kName,
       [](const SuiteConfig& config) -> std::unique_ptr<SuiteStage> {
         return std::make_unique<InformationStage>(config.information_map, config.vehicle,
                                                   config.hymm_grid.image);
       }},
      {DoorStage::kName,
       [](const SuiteConfig& config) -> std::unique_ptr<SuiteStage> {
         return std::make_unique<DoorStage>(config.door_planner);
       }},
      {RelocaliserStage::kName,
       [](const SuiteConfig& config) -> std::unique_ptr<SuiteStage> {
         return std::make_unique<RelocaliserStage>(config.relocaliser, config.vehicle);
       }},
      {SupervisorStage::kName,
       [](const SuiteConfig& config) -> std::unique_ptr<SuiteStage> {
         return std::make_unique<SupervisorStage>(config.supervisor);
       }},
  };
  return kinds;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

template <class Stage>
Stage* findStage(const std::vector<std::unique_ptr<SuiteStage>>& stages) {
  for (const auto& stage : stages) {
    if (auto* found = dynamic_cast<Stage*>(stage.get())) return found;
  }
  return nullptr;
}

/// Stages that read what others make.
void connect(const std::vector<std::unique_ptr<SuiteStage>>& stages) {
  auto* doors = findStage<DoorStage>(stages);
  const auto* grid = findStage<GridStage>(stages);
  if (auto* supervisor = findStage<SupervisorStage>(stages)) {
    supervisor->watch(grid, findStage<RelocaliserStage>(stages));
  }
  if (grid == nullptr) return;
  if (doors != nullptr) doors->readMapOf(grid->mapper());
  if (auto* information = findStage<InformationStage>(stages)) {
    information->readMapOf(grid->mapper());
  }
}

}  // namespace

std::vector<std::string> nodeNames() {
  std::vector<std::string> names = {kFilter};
  for (const StageKind& kind : stageKinds()) names.emplace_back(kind.name);
  return names;
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::vector<std::string> chosenNodes(const std::vector<std::string>& only) {
  const std::vector<std::string> known = nodeNames();
  if (only.empty()) return known;
  std::vector<std::string> problems;
  for (const std::string& name : only) {
    if (contains(known, name)) continue;
    problems.push_back("--only: there is no subsystem '" + name + "' in this version; there are " +
                       listOf(known) + ".");
  }
  if (!contains(only, kFilter)) {
    problems.push_back(std::string("--only: all others need ") + kFilter + "; name it as well.");
  }
  if (contains(only, DoorStage::kName) && !contains(only, GridStage::kName)) {
    problems.push_back(std::string("--only: ") + DoorStage::kName + " needs " + GridStage::kName +
                       "; name it as well.");
  }
  if (contains(only, RelocaliserStage::kName) && !contains(only, SupervisorStage::kName)) {
    problems.push_back(std::string("--only: ") + RelocaliserStage::kName + " is asked by " +
                       SupervisorStage::kName + "; name it as well.");
  }
  if (!problems.empty()) throw ConfigError(problems);
  return only;
}

std::vector<std::unique_ptr<SuiteStage>> makeStages(const std::vector<std::string>& nodes,
                                                    const SuiteConfig& config) {
  std::vector<std::unique_ptr<SuiteStage>> stages;
  for (const StageKind& kind : stageKinds()) {
    if (contains(nodes, kind.name)) stages.push_back(kind.make(config));
  }
  connect(stages);
  return stages;
}

const SupervisorStage* findSupervisor(const std::vector<std::unique_ptr<SuiteStage>>& stages) {
  return findStage<SupervisorStage>(stages);
}

}  // namespace hymm::core
