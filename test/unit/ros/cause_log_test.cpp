#include "ros/cause_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(CauseLog, CountsByCause) {
  CauseLog causes;
  for (const char* cause : {"no time stamp", "unknown frame", "no time stamp"})
    causes.count(cause, "A sentence.");
  EXPECT_THAT(causes.counts(), ElementsAre(Pair("no time stamp", 2), Pair("unknown frame", 1)));
  EXPECT_EQ(causes.total(), 3u);
}

TEST(CauseLog, StaysSmallHoweverManyNamesCome) {
  CauseLog causes;
  for (int i = 0; i < 1000; ++i)
    causes.count("unknown frame '" + std::to_string(i) + std::string(1000, 'x') + "'",
                 "A sentence.");
  EXPECT_EQ(causes.counts().size(), CauseLog::kMostCauses + 1);
  EXPECT_EQ(causes.counts().at(CauseLog::kOthers), 1000 - CauseLog::kMostCauses);
  for (const auto& [cause, count] : causes.counts())
    EXPECT_LE(cause.size(), CauseLog::kLongestCause);
  EXPECT_EQ(causes.total(), 1000u);
}

}  // namespace
}  // namespace hymm
