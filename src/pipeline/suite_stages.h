#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/suite_config.h"
#include "pipeline/suite_stage.h"

namespace hymm::core {

class SupervisorStage;

/// Names of the nodes that a run can have, in the order in which they work: the filter first, which
/// is always there.
std::vector<std::string> nodeNames();

/// The names with commas between them.
std::string listOf(const std::vector<std::string>& names);

/// Which nodes to run: those of `only`, or all if it is empty. Throws ConfigError that lists the
/// names there are if one is not known, or if the filter is missing.
std::vector<std::string> chosenNodes(const std::vector<std::string>& only);

/// The stages of these nodes, in their order. Throws ConfigError if one's configuration is
/// unusable.
std::vector<std::unique_ptr<SuiteStage>> makeStages(const std::vector<std::string>& nodes,
                                                    const SuiteConfig& config);

/// The supervisor among them; null if it does not run.
const SupervisorStage* findSupervisor(const std::vector<std::unique_ptr<SuiteStage>>& stages);

}  // namespace hymm::core
