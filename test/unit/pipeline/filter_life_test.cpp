#include "pipeline/filter_life.h"

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

FilterCounters countersAt(std::uint64_t version, std::uint64_t resets = 0,
                          std::uint64_t scans = 0) {
  return {version, resets, scans};
}

class TheFilterLife : public ::testing::Test {
 protected:
  TheFilterLife() { life_.take(countersAt(225, 1, 300)); }
  FilterLife life_;
};

TEST(FilterLife, GoesOnWithWhateverComesFirst) {
  FilterLife life;
  EXPECT_EQ(life.take(countersAt(225, 3, 300)), FilterCourse::kGoesOn);
}

TEST_F(TheFilterLife, GoesOnWhileNothingRunsBack) {
  EXPECT_EQ(life_.take(countersAt(225, 1, 300)), FilterCourse::kGoesOn);  // a map, sent once more
  EXPECT_EQ(life_.take(countersAt(240, 1, 310)), FilterCourse::kGoesOn);  // some got lost
}

TEST_F(TheFilterLife, TellsAMapThatTheSameFilterBegan) {
  EXPECT_EQ(life_.take(countersAt(227, 2, 301)), FilterCourse::kNewMap);
  EXPECT_EQ(life_.take(countersAt(228, 2, 302)), FilterCourse::kGoesOn);
}

TEST_F(TheFilterLife, TellsAFilterThatWasStartedAnewByEachCount) {
  for (const FilterCounters& first :
       {countersAt(2, 1, 300), countersAt(226, 0, 301), countersAt(226, 1, 1)}) {
    FilterLife life = life_;
    EXPECT_EQ(life.take(first), FilterCourse::kNewFilter);
    EXPECT_NE(life.take(countersAt(227, 1, 302)), FilterCourse::kNewFilter);
  }
}

TEST_F(TheFilterLife, TellsEachFilterOnce) {
  EXPECT_EQ(life_.take(countersAt(2, 0, 2)), FilterCourse::kNewFilter);
  EXPECT_EQ(life_.take(countersAt(3, 0, 3)), FilterCourse::kGoesOn);
  EXPECT_EQ(life_.take(countersAt(300, 0, 300)), FilterCourse::kGoesOn);  // beyond the one before
  EXPECT_EQ(life_.take(countersAt(1, 0, 1)), FilterCourse::kNewFilter);
}

TEST_F(TheFilterLife, LooksAheadWithoutTaking) {
  EXPECT_EQ(life_.courseOf(countersAt(2)), FilterCourse::kNewFilter);
  EXPECT_EQ(life_.courseOf(countersAt(2)), FilterCourse::kNewFilter);
  EXPECT_EQ(life_.take(countersAt(226, 1, 301)), FilterCourse::kGoesOn);
}

}  // namespace
}  // namespace hymm::core
