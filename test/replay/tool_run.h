#pragma once

#include <cstdlib>
#include <string>

#include <sys/wait.h>

#include "support/temporary_folder.h"

namespace hymm::test {

/// What a tool did: its exit code, stdout and stderr.
struct ToolRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs a command line in a shell.
inline ToolRun runTool(const std::string& command) {
  const TemporaryFolder folder;
  const int status =
      std::system((command + " > " + (folder / "out") + " 2> " + (folder / "err")).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.read("out"), folder.read("err")};
}

}  // namespace hymm::test
