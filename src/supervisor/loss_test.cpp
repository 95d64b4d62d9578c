#include "supervisor/loss_test.h"

#include <algorithm>
#include <cmath>

#include "supervisor/suspicion.h"

namespace hymm::core {
namespace {

// Only then unexplained observations count.
const double kMuchDoubt = std::log(10.0);

/// Log likelihood ratio of lost and in good order, of `hits` in `trials`.
double logRatioOf(double hits, double trials, double share, double lost_share) {
  return hits * std::log(lost_share / share) +
         (trials - hits) * std::log((1.0 - lost_share) / (1.0 - share));
}

}  // namespace

void LossTestConfig::describe(ConfigSchema& schema) {
  schema.number("seen_share", seen_share, Range::between(0.1, 0.99),
                "least share of the confirmed landmarks in clear view that a filter in good order "
                "sees");
  schema.number("lost_seen_share", lost_seen_share, Range::between(0.001, 0.5),
                "share of them that a lost filter sees, by chance");
  schema.number("explained_share", explained_share, Range::between(0.1, 0.99),
                "least share of the observations that a filter in good order explains where "
                "confirmed landmarks are in view");
  schema.number("lost_explained_share", lost_explained_share, Range::between(0.001, 0.5),
                "share of them that a lost filter explains, by chance");
  schema.number("independent_s", independent_s, Range::between(0.05, 60.0),
                "time after which a scan shows something new: what hides a landmark has moved on");
  schema.number("false_alarm_interval_h", false_alarm_interval_h, Range::between(0.01, 10000.0),
                "expected time in good order between two false alarms, at least");
}

double LossTest::limit(const LossTestConfig& config) {
  return std::log(3600.0 * config.false_alarm_interval_h / config.independent_s);
}

bool LossTest::doubtsMuch() const { return log_ratio_ >= kMuchDoubt; }

bool LossTest::alarms(const LossTestConfig& config) const { return log_ratio_ > limit(config); }

LossTest LossTest::after(double time_s, const ScanEvidence& scan, double longest_doubt_s,
                         const LossTestConfig& config) const {
  const double since_s = scan_s_ ? time_s - *scan_s_ : 0.0;
  const double weight = std::clamp(since_s / config.independent_s, 0.0, 1.0);
  const int seen = scan.confirmed_expected - scan.confirmed_missed;
  double ratio = 0.0;
  if (scan.confirmed_expected > 0) {
    ratio = logRatioOf(seen, scan.confirmed_expected, config.seen_share, config.lost_seen_share);
  } else if (doubtsMuch()) {
    ratio = logRatioOf(1.0 - scan.unexplained, 1.0, config.explained_share,
                       config.lost_explained_share);
  }
  LossTest next = *this;
  next.scan_s_ = time_s;
  next.log_ratio_ = std::max(0.0, log_ratio_ + weight * ratio);
  const bool is_stale = time_s - good_order_s_ > longest_doubt_s;
  if (is_stale && !next.alarms(config)) next.log_ratio_ = 0.0;
  if (!next.doubts()) next.good_order_s_ = time_s;
  return next;
}

}  // namespace hymm::core
