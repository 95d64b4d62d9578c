#pragma once

#include <cstddef>
#include <vector>

namespace hymm::core {

/// A span of time, both ends included.
struct TimeWindow {
  double from_s;
  double to_s;

  bool contains(double time_s) const { return time_s >= from_s && time_s <= to_s; }
};

/// Lengths of errors, in the unit of the errors. All zero when there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0;
  double median = 0.0;  ///< mean of the two in the middle where their number is even
  double max = 0.0;
};

ErrorStatistics errorStatistics(std::vector<double> errors);

/// Whether squared errors, in units of their stated covariance, are as large as they should be.
struct Consistency {
  std::size_t count = 0;
  double mean_per_dof = 0.0;  ///< sum of the values over sum of their degrees of freedom
  double mean = 0.0;
  double share_in_band = 0.0;  ///< of values between the 2.5 % and 97.5 % quantiles of chi-square
};

/// Gathers normalised squared errors (NEES, NIS) with their degrees of freedom.
class ConsistencySum {
 public:
  /// A value with no degrees of freedom, or that is not finite, is not counted.
  void add(double squared_error, int dof);

  Consistency result() const;

 private:
  struct Band {
    double low;
    double high;
  };
  const Band& band(int dof);

  std::vector<Band> bands_;  ///< by degrees of freedom
  std::size_t count_ = 0, in_band_ = 0;
  double sum_ = 0.0, dof_ = 0.0;
};

}  // namespace hymm::core
