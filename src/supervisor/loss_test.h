#pragma once

#include <optional>

#include "common/config.h"

namespace hymm::core {

struct ScanEvidence;

/// What scans are like under a filter that is in good order at worst, and under one that is lost.
struct LossTestConfig {
  double seen_share = 0.7;              ///< of confirmed landmarks in clear view, in good order
  double lost_seen_share = 0.05;        ///< ... and lost: by chance
  double explained_share = 0.5;         ///< of the observations, in good order
  double lost_explained_share = 0.1;    ///< ... and lost
  double independent_s = 1.0;           ///< after which a scan shows something new
  double false_alarm_interval_h = 1.0;  ///< expected between false alarms, at least

  void describe(ConfigSchema& schema);
};

/// How much likelier it is that the filter is lost than that it is in good order, by what scans
/// since a moment show: Page's sequential test (CUSUM). At each moment it holds the greatest log
/// likelihood ratio of "lost since then" over all moments before.
///
/// Confirmed landmarks that nothing hides are seen or missed independently of each other. Where
/// none is left in view, since a lost filter drops them, the share of the observations that is
/// explained counts as one sample, but only once landmarks were missed: on new ground nothing is
/// explained. Scans within `independent_s` share the weight of one. Under a filter in good order
/// the exponential of each summand then has an expectation of at most 1, so that false alarms are
/// at least independent_s * exp(limit) apart in expectation (Lorden, 1971).
class LossTest {
 public:
  /// The test after one more scan. Doubt that has come to nothing within `longest_doubt_s` is
  /// dropped. Pure.
  LossTest after(double time_s, const ScanEvidence& scan, double longest_doubt_s,
                 const LossTestConfig& config) const;

  double logRatio() const { return log_ratio_; }
  bool doubts() const { return log_ratio_ > 0.0; }
  /// Whether a loss is ten times as likely as none.
  bool doubtsMuch() const;
  bool alarms(const LossTestConfig& config) const;
  /// The last scan that left no doubt.
  double goodOrder_s() const { return good_order_s_; }

  /// log(false_alarm_interval / independent_s)
  static double limit(const LossTestConfig& config);

 private:
  double log_ratio_ = 0.0;
  std::optional<double> scan_s_;  ///< the last one
  double good_order_s_ = 0.0;
};

}  // namespace hymm::core
