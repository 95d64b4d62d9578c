#include "pipeline/line_file.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "common/error.h"
#include "support/full_disk.h"
#include "support/temporary_folder.h"

namespace hymm::core {
namespace {

TEST(LineFile, TouchesNothingBeforeTheFirstFlush) {
  const test::TemporaryFolder folder;
  folder.write("lines", "of an earlier run\n");
  LineFile file(folder / "lines");
  file.add("new");
  EXPECT_EQ(folder.read("lines"), "of an earlier run\n");
  file.flush();
  EXPECT_EQ(folder.read("lines"), "new\n");
}

TEST(LineFile, GrowsWithEachFlush) {
  const test::TemporaryFolder folder;
  LineFile file(folder / "lines");
  file.flush();
  EXPECT_EQ(folder.read("lines"), "");
  file.add("one");
  file.add("two");
  file.flush();
  file.add("three");
  EXPECT_EQ(file.waiting(), 6u);
  file.flush();
  file.flush();
  EXPECT_EQ(folder.read("lines"), "one\ntwo\nthree\n");
  EXPECT_EQ(file.waiting(), 0u);
}

TEST(LineFile, LinesThatDidNotFitAreWrittenWhenThereIsRoomAgain) {
  const test::TemporaryFolder folder;
  LineFile file(folder / "lines");
  file.add("before");
  file.flush();
  const std::string long_line(100, 'x');
  file.add(long_line);
  {
    const test::FullDisk disk(50);
    EXPECT_THROW(file.flush(), OutputError);
    EXPECT_EQ(folder.read("lines"), "before\n");
    EXPECT_THROW(file.flush(), OutputError);
  }
  file.add("after");
  file.flush();
  EXPECT_EQ(folder.read("lines"), "before\n" + long_line + "\nafter\n");
}

TEST(LineFile, AFirstFlushThatFailsIsMadeUpFor) {
  const test::TemporaryFolder folder;
  LineFile file(folder / "lines");
  file.add("much");
  {
    const test::FullDisk disk(2);
    EXPECT_THROW(file.flush(), OutputError);
    EXPECT_EQ(folder.read("lines"), "");
  }
  file.flush();
  EXPECT_EQ(folder.read("lines"), "much\n");
}

TEST(LineFile, FilesThatAreFlushedTogetherGrowTogetherOrNotAtAll) {
  const test::TemporaryFolder folder;
  LineFile small(folder / "small"), large(folder / "large");
  const auto flush = [&] { LineFile::flushTogether({&small, &large}); };
  small.add("1");
  large.add("1");
  flush();
  small.add("2");
  large.add(std::string(100, '2'));
  {
    const test::FullDisk disk(50);
    EXPECT_THROW(flush(), OutputError);
    EXPECT_EQ(folder.read("small"), "1\n");
    EXPECT_EQ(folder.read("large"), "1\n");
  }
  flush();
  EXPECT_EQ(folder.read("small"), "1\n2\n");
  EXPECT_EQ(folder.read("large"), "1\n" + std::string(100, '2') + "\n");
}

TEST(LineFile, OneThatIsGoneIsNotBegunInTheMiddle) {
  const test::TemporaryFolder folder;
  LineFile file(folder / "lines");
  file.add("one");
  file.flush();
  std::filesystem::remove(folder / "lines");
  file.add("two");
  EXPECT_THROW(file.flush(), OutputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "lines"));
}

}  // namespace
}  // namespace hymm::core
