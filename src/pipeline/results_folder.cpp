#include "pipeline/results_folder.h"

#include <system_error>

#include <unistd.h>

#include "common/error.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

// summary.json first: a folder without it is known to hold no complete run.
constexpr const char* kNames[] = {"summary.json",
                                  "report.html",
                                  "trajectory.tum",
                                  "pose_covariance.csv",
                                  "landmarks.csv",
                                  "health.csv",
                                  "gps.csv",
                                  "events.csv",
                                  "observations.csv",
                                  "ltrs.csv",
                                  "map_memory.csv",
                                  "map.pgm",
                                  "map.yaml",
                                  "level_sets.csv",
                                  "information_changes.csv",
                                  "exploration.csv",
                                  "plan.csv",
                                  "doors.csv",
                                  "plan_queries.csv"};

void removeFile(const fs::path& path) {
  std::error_code problem;
  if (fs::is_directory(path, problem)) return;  // no run has made it
  fs::remove(path, problem);
  if (!problem) return;
  throw OutputError(path.string() + ", of an earlier run, cannot be removed: " + problem.message() +
                    ".");
}

}  // namespace

fs::path makeResultsFolder(const std::string& folder) {
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) throw OutputError(folder + ": cannot be made: " + problem.message() + ".");
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw OutputError(folder + ": cannot be written to; check its permissions.");
  }
  return folder;
}

void removeResults(const fs::path& folder) {
  for (const char* name : kNames) {
    removeFile(folder / name);
    removeFile(folder / (std::string(name) + ".active"));  // in the making when a run was killed
  }
}

}  // namespace hymm::core
