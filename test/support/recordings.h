#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace hymm::test {

/// Path of a public recording below $HYMM_DATA; empty where that is not set, or empty.
inline std::filesystem::path recording(const std::string& name) {
  const char* root = std::getenv("HYMM_DATA");
  return root == nullptr || *root == '\0' ? std::filesystem::path()
                                          : std::filesystem::path(root) / name;
}

}  // namespace hymm::test

/// Skips a test that needs the recording `name`, and says why.
#define HYMM_SKIP_WITHOUT_RECORDING(name)                                                      \
  if (::hymm::test::recording(name).empty())                                                   \
  GTEST_SKIP() << "needs the recording " << (name) << "; HYMM_DATA, the folder of recordings," \
               << " is not set"
