#include "pipeline/results_folder.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

namespace fs = std::filesystem;

TEST(ResultsFolder, IsMadeWithThoseAboveIt) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(makeResultsFolder(folder / "a/b"), fs::path(folder / "a/b"));
  EXPECT_TRUE(fs::is_directory(folder / "a/b"));
}

TEST(ResultsFolder, BelowAFileIsTold) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("file", "");
  EXPECT_THROW(makeResultsFolder(file + "/results"), OutputError);
}

TEST(ResultsFolder, LosesTheFilesOfARunAndNothingElse) {
  const test::TemporaryFolder folder;
  for (const char* ours : {"summary.json", "map.pgm", "map.yaml", "plan_queries.csv", "report.html",
                           "ltrs.csv.active"}) {
    folder.write(ours, "of an earlier run");
  }
  for (const char* other :
       {"notes.txt", "drive.bag", "map.txt", "map.png", "my_summary.json", "kept/summary.json"}) {
    folder.write(other, "of the user");
  }
  fs::create_directory(folder / "doors.csv");  // of the user too: no run makes a folder
  removeResults(folder.path());
  std::vector<std::string> left;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    left.push_back(fs::relative(entry.path(), folder.path()).string());
  }
  EXPECT_THAT(left, testing::UnorderedElementsAre("notes.txt", "drive.bag", "map.txt", "map.png",
                                                  "my_summary.json", "kept", "kept/summary.json",
                                                  "doors.csv"));
}

TEST(ResultsFolder, ThatHoldsNothingStaysSo) {
  const test::TemporaryFolder folder;
  removeResults(folder.path());
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace hymm::core
