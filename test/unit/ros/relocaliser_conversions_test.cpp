#include "ros/relocaliser_conversions.h"

#include <gtest/gtest.h>

namespace hymm {
namespace {

using State = core::RelocaliserEvidence::State;

TEST(RelocaliserConversions, EachStateIsTheEvidenceThatItShouldBe) {
  const std::vector<std::pair<core::SearchState, State>> pairs = {
      {core::SearchState::kIdle, State::kSearching},
      {core::SearchState::kSearching, State::kSearching},
      {core::SearchState::kAccepted, State::kAccepted},
      {core::SearchState::kRefused, State::kRefused},
      {core::SearchState::kFailed, State::kFailed}};
  for (const auto& [state, evidence] : pairs) {
    core::SearchReport report;
    report.state = state;
    report.reason = "why";
    report.order = 3;
    const RelocaliserHealth message = toMessage(report, "map");
    EXPECT_EQ(message.order, 3U);
    EXPECT_EQ(evidenceFrom(message).state, evidence) << message.state;
    EXPECT_EQ(evidenceFrom(message).reason, "why");
  }
}

TEST(RelocaliserConversions, PathKeepsStampsAndPlaces) {
  const std::vector<core::PlaceAtScan> path = {{100.25, {1.0, 2.0, 0.3}},
                                               {100.45, {2.0, 2.5, 0.4}}};
  const auto back = fromMessage(toMessage(path, "map"));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[1].time_s, 100.45);
  EXPECT_EQ(back[1].T_map_base.position(), path[1].T_map_base.position());
  EXPECT_NEAR(back[1].T_map_base.yaw_rad, 0.4, 1e-12);
}

}  // namespace
}  // namespace hymm
