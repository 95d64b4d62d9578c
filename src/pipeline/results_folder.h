#pragma once

#include <filesystem>
#include <string>

namespace hymm::core {

/// Makes a folder for the results of a run, if it is missing, and touches nothing in it. Throws
/// OutputError if it cannot be made or written to.
std::filesystem::path makeResultsFolder(const std::string& folder);

/// Removes what an earlier run left in a folder of results: the files that a run, live or offline,
/// writes under names of its own, finished or not, and the report that was made of them. What would
/// stay of them, this run's figures would be mixed with. Nothing else is touched. Throws
/// OutputError.
void removeResults(const std::filesystem::path& folder);

}  // namespace hymm::core
