#include "ros/traffic_meter.h"

#include <map>

#include <gmock/gmock.h>

namespace hymm {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using diagnostic_updater::DiagnosticStatusWrapper;
using testing::HasSubstr;

class TrafficMeterTest : public testing::Test {
 protected:
  DiagnosticStatusWrapper tell() {
    DiagnosticStatusWrapper status;
    meter_.diagnose(status);
    values_.clear();
    for (const diagnostic_msgs::KeyValue& value : status.values) values_[value.key] = value.value;
    return status;
  }

  double now_s_ = 100.0;
  TrafficMeter meter_{[this] { return now_s_; }};
  std::map<std::string, std::string> values_;  ///< as last told
};

TEST_F(TrafficMeterTest, TellsNumberRateAndAge) {
  meter_.watch("/scan");
  for (int i = 0; i < 10; ++i) {
    now_s_ += 0.2;
    meter_.note("/scan");
  }
  now_s_ += 0.5;
  tell();
  EXPECT_EQ(values_["/scan messages"], "10");
  EXPECT_EQ(values_["/scan rate [Hz, wall]"], "4");
  EXPECT_EQ(values_["/scan age [s, wall]"], "0.5");
}

TEST_F(TrafficMeterTest, RateIsOfTheTimeSinceItWasLastTold) {
  meter_.watch("/scan");
  for (int i = 0; i < 7; ++i) meter_.note("/scan");
  now_s_ += 1.0;
  tell();
  meter_.note("/scan");
  now_s_ += 2.0;
  tell();
  EXPECT_EQ(values_["/scan messages"], "8");
  EXPECT_EQ(values_["/scan rate [Hz, wall]"], "0.5");
}

TEST_F(TrafficMeterTest, WarnsOfAnExpectedTopicThatNeverCame) {
  meter_.expect("/scan");
  const DiagnosticStatusWrapper status = tell();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_THAT(status.message, HasSubstr("Nothing has come on /scan"));
}

TEST_F(TrafficMeterTest, WarnsOfAnExpectedTopicThatStopped) {
  meter_.expect("/scan");
  meter_.note("/scan");
  EXPECT_EQ(tell().level, DiagnosticStatus::OK);
  now_s_ += 5.0;
  const DiagnosticStatusWrapper status = tell();
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_THAT(status.message, HasSubstr("Nothing comes on /scan any more"));
}

TEST_F(TrafficMeterTest, OtherTopicsMayStaySilent) {
  meter_.watch("/initialpose");
  now_s_ += 50.0;
  EXPECT_EQ(tell().level, DiagnosticStatus::OK);
  EXPECT_EQ(values_["/initialpose age [s, wall]"], "50");
}

}  // namespace
}  // namespace hymm
