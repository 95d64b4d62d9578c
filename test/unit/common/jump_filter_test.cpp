#include "common/jump_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Stamped {
  double time_s;
};

class JumpFilterTest : public testing::Test {
 protected:
  /// The times of what may be used now; a run back is told by a -1 before them.
  std::vector<double> push(double time_s) {
    const auto answer = filter_.push({time_s});
    std::vector<double> times;
    if (answer.ran_back) times.push_back(-1.0);
    for (const Stamped& event : answer.events) times.push_back(event.time_s);
    return times;
  }

  JumpFilter<Stamped> filter_{1.0, 3};
};

TEST_F(JumpFilterTest, PassesOnWhatIsInOrderOrALittleOutOfIt) {
  for (const double t : {10.0, 10.5, 10.4, 11.4}) EXPECT_THAT(push(t), ElementsAre(t));
  EXPECT_EQ(filter_.strays(), 0U);
}

TEST_F(JumpFilterTest, OneStampFarAheadHarmsNothing) {
  push(10.0);
  EXPECT_THAT(push(110.0), IsEmpty());
  for (const double t : {10.1, 10.2, 10.3, 10.4}) EXPECT_THAT(push(t), ElementsAre(t));
  EXPECT_EQ(filter_.strays(), 1U);
}

TEST_F(JumpFilterTest, OneStampOfThePastHarmsNothing) {
  push(110.0);
  EXPECT_THAT(push(10.0), IsEmpty());
  for (const double t : {110.1, 110.2, 110.3}) EXPECT_THAT(push(t), ElementsAre(t));
  EXPECT_EQ(filter_.strays(), 1U);
}

TEST_F(JumpFilterTest, StraysThatDoNotAgreeAreNoJump) {
  push(10.0);
  for (const double t : {110.0, 5.0, 300.0, 4.0, 500.0}) EXPECT_THAT(push(t), IsEmpty());
  EXPECT_THAT(push(10.1), ElementsAre(10.1));
  EXPECT_EQ(filter_.strays(), 5U);
}

TEST_F(JumpFilterTest, AGapIsBelievedWithTheThirdMessageAndLosesNone) {
  push(10.0);
  EXPECT_THAT(push(3610.0), IsEmpty());
  EXPECT_THAT(push(3610.1), IsEmpty());
  EXPECT_THAT(push(3610.2), ElementsAre(3610.0, 3610.1, 3610.2));
  EXPECT_THAT(push(3610.3), ElementsAre(3610.3));
  EXPECT_EQ(filter_.strays(), 0U);
}

TEST_F(JumpFilterTest, ARunBackIsToldWithTheThirdMessageAndLosesNone) {
  push(110.0);
  EXPECT_THAT(push(10.0), IsEmpty());
  EXPECT_THAT(push(10.1), IsEmpty());
  EXPECT_THAT(push(10.2), ElementsAre(-1.0, 10.0, 10.1, 10.2));
  EXPECT_THAT(push(10.3), ElementsAre(10.3));
}

TEST_F(JumpFilterTest, MessagesFartherApartThanAJumpComeLateButAllOfThem) {
  std::vector<double> passed;
  for (int i = 0; i < 10; ++i) {
    for (const double t : push(10.0 + 2.0 * i)) passed.push_back(t);
  }
  EXPECT_THAT(passed, ElementsAre(10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0));
}

}  // namespace
}  // namespace hymm::core
