#include "evaluation/error_statistics.h"

#include <algorithm>
#include <cmath>

#include "common/chi_square.h"

namespace hymm::core {

ErrorStatistics errorStatistics(std::vector<double> errors) {
  ErrorStatistics statistics;
  if (errors.empty()) return statistics;
  std::sort(errors.begin(), errors.end());
  const std::size_t n = errors.size();
  double squares = 0.0;
  for (const double error : errors) squares += error * error;
  statistics.count = n;
  statistics.rmse = std::sqrt(squares / static_cast<double>(n));
  statistics.median = (errors[(n - 1) / 2] + errors[n / 2]) / 2.0;
  statistics.max = errors.back();
  return statistics;
}

void ConsistencySum::add(double squared_error, int dof) {
  if (dof <= 0 || !std::isfinite(squared_error)) return;
  ++count_;
  sum_ += squared_error;
  dof_ += dof;
  const Band& limits = band(dof);
  if (squared_error >= limits.low && squared_error <= limits.high) ++in_band_;
}

const ConsistencySum::Band& ConsistencySum::band(int dof) {
  for (int next = static_cast<int>(bands_.size()); next <= dof; ++next) {
    bands_.push_back(next == 0
                         ? Band{0.0, 0.0}
                         : Band{chiSquareQuantile(0.025, next), chiSquareQuantile(0.975, next)});
  }
  return bands_[static_cast<std::size_t>(dof)];
}

Consistency ConsistencySum::result() const {
  Consistency result;
  result.count = count_;
  if (count_ == 0) return result;
  const auto n = static_cast<double>(count_);
  result.mean = sum_ / n;
  result.mean_per_dof = sum_ / dof_;
  result.share_in_band = static_cast<double>(in_band_) / n;
  return result;
}

}  // namespace hymm::core
