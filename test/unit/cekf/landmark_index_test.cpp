#include "cekf/landmark_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hymm::core {
namespace {

using testing::ElementsAre;

class Index : public testing::Test {
 protected:
  Index() {
    index_.place(7, {-3.0, 2.0});
    index_.place(3, {50.0, -20.0});
    index_.place(5, {1000.0, 1000.0});
  }
  LandmarkIndex index_;
};

TEST_F(Index, FindsWhatIsNear) {
  EXPECT_THAT(index_.near({-2.0, 0.0}, 10.0), ElementsAre(7));
  EXPECT_THAT(index_.near({0.0, 0.0}, 60.0), ElementsAre(3, 7));
  EXPECT_THAT(index_.near({500.0, 0.0}, 10.0), ElementsAre());
}

TEST_F(Index, FindsEverythingAtOnceFromAnywhere) {
  // A walk over the cells of these squares would take minutes, or for ever.
  for (const double radius_m : {1e6, 1e12, 1e300}) {
    EXPECT_THAT(index_.near({0.0, 0.0}, radius_m), ElementsAre(3, 5, 7));
  }
}

}  // namespace
}  // namespace hymm::core
