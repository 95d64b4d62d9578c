#pragma once

#include <deque>

namespace hymm::core {

/// How well scans agree with the dense map, as `hymm_grid` tells it once a second. It is a little
/// behind the filter, by the machine's speed; so a scan is judged by what was told of one a fixed
/// time before it, and decisions do not depend on when messages arrive.
class GridAgreement {
 public:
  /// `correlation`: 1 where scan and map agree, 0 where they have nothing to do with each other;
  /// NaN: not known. In order of time.
  void take(double time_s, double correlation);
  void clear() { told_.clear(); }

  /// Share of the agreement that a scan at `time_s` lacks, 0 to 1; 0 where nothing is known.
  double disagreementAt(double time_s) const;

 private:
  struct Told {
    double time_s;
    double correlation;
  };

  std::deque<Told> told_;
};

}  // namespace hymm::core
