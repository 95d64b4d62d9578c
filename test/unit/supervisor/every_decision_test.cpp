#include <optional>
#include <vector>

#include <gmock/gmock.h>

#include "scan_evidence.h"

namespace hymm::core {
namespace {

using ::testing::EndsWith;

/// Every mode with every combination of what can be told.
class EveryDecision : public ::testing::Test {
 protected:
  struct Case {
    SupervisorState state;
    SupervisorEvidence evidence;
  };

  static std::vector<SupervisorState> states() {
    std::vector<SupervisorState> states;
    for (const auto mode : {FilterMode::kInitialising, FilterMode::kCekf, FilterMode::kRelocalising,
                            FilterMode::kLost}) {
      for (const int attempts : {0, 1, 3, 4}) {
        for (const double age_s : {0.0, 10.0, 1000.0}) {
          for (const int suspicious : {0, 2, 9}) {
            for (const double wait_s : {-1.0, 5.0}) {
              SupervisorState state = stateIn(mode, attempts);
              state.since_s = kNow_s - age_s;
              state.suspicious_scans = suspicious;
              state.suspicious_s = kPeriod_s * suspicious;
              state.not_before_s = kNow_s + wait_s;
              state.good_order_s = kNow_s - 2.0;
              state.waits_from_s = kNow_s - 2.0 * age_s;
              states.push_back(state);
            }
          }
        }
      }
    }
    return states;
  }

  static std::vector<SupervisorEvidence> evidences() {
    std::vector<SupervisorEvidence> evidences;
    for (const bool posed : {false, true}) {
      for (const bool doubtful : {false, true}) {
        for (const bool armed : {false, true}) {
          for (const bool silent : {false, true}) {
            for (const std::optional<Search> search :
                 {std::optional<Search>(), std::optional(Search::kSearching),
                  std::optional(Search::kAccepted), std::optional(Search::kRefused),
                  std::optional(Search::kFailed)}) {
              for (const int request : {0, 1, 2}) {
                SupervisorEvidence evidence = doubtful ? ambiguous() : healthy();
                if (!posed) evidence.pose_age_s.reset();
                if (armed) evidence.scan.position_deviation_m = 10.0;
                if (search) evidence = withRelocaliser(evidence, *search);
                if (search && silent) evidence.relocaliser->age_s = 100.0;
                if (request == 1) evidence.requested = FilterMode::kCekf;
                if (request == 2) evidence.requested = FilterMode::kRelocalising;
                evidences.push_back(evidence);
                evidence.waits = true;
                evidences.push_back(evidence);
              }
            }
          }
        }
      }
    }
    return evidences;
  }

  template <class Check>
  static void forEach(Check check) {
    const SupervisorConfig config;
    const auto all_evidences = evidences();
    for (const SupervisorState& state : states()) {
      for (const SupervisorEvidence& evidence : all_evidences) {
        check(state, evidence, computeDecision(state, evidence, config));
      }
    }
  }
};

TEST_F(EveryDecision, StatesItsReasonAndRemembersItsMode) {
  forEach([](const SupervisorState&, const SupervisorEvidence&, const SupervisorDecision& d) {
    EXPECT_FALSE(d.reason.empty());
    EXPECT_THAT(d.reason, EndsWith(d.mode == FilterMode::kInitialising ? "?" : "."));
    EXPECT_EQ(d.state.mode, d.mode);
  });
}

TEST_F(EveryDecision, ActsExactlyWhenItSwitchesAwayFromAFilterOrHandsBack) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool switches = isModeSwitch(state.mode, d.mode);
    switch (d.action) {
      case SupervisorAction::kBeginRelocalising:
        EXPECT_EQ(d.mode, FilterMode::kRelocalising);
        EXPECT_TRUE(switches || evidence.requested == FilterMode::kRelocalising);
        EXPECT_EQ(d.state.attempts, state.attempts + 1);
        break;
      case SupervisorAction::kResumeWithoutClosing:
        EXPECT_TRUE(switches && d.mode == FilterMode::kCekf);
        break;
      case SupervisorAction::kEndWaiting:
        EXPECT_TRUE(evidence.waits && state.mode == FilterMode::kCekf && d.mode == state.mode);
        break;
      case SupervisorAction::kNothing:
        EXPECT_NE(switches, d.mode == state.mode || state.mode == FilterMode::kInitialising);
        EXPECT_FALSE(switches && d.mode == FilterMode::kRelocalising);
        break;
    }
  });
}

TEST_F(EveryDecision, NeverRelocalisesWithoutARelocaliser) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool hears = evidence.relocaliser && evidence.relocaliser->age_s < 1.0;
    if (hears || state.mode == FilterMode::kRelocalising) return;
    EXPECT_NE(d.mode, FilterMode::kRelocalising);
  });
}

TEST_F(EveryDecision, NeverLeavesAHealthyCekfUnlessAsked) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    const bool asked = evidence.requested == FilterMode::kRelocalising;
    if (state.mode != FilterMode::kCekf || evidence.scan.ambiguity > 0.0 || asked) return;
    EXPECT_EQ(d.mode, FilterMode::kCekf);
  });
}

TEST_F(EveryDecision, ReturnsToTheCekfOnlyByItsConsentOrWithoutClosing) {
  forEach([](const SupervisorState& state, const SupervisorEvidence& evidence,
             const SupervisorDecision& d) {
    if (d.mode != FilterMode::kCekf || !isModeSwitch(state.mode, d.mode)) return;
    const bool accepted = evidence.relocaliser && evidence.relocaliser->state == Search::kAccepted;
    EXPECT_TRUE(accepted || d.action == SupervisorAction::kResumeWithoutClosing);
  });
}

}  // namespace
}  // namespace hymm::core
