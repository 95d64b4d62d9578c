#include "cekf/joint_factor.h"

#include <cmath>
#include <limits>

namespace hymm::core {

using Eigen::Index;

JointFactor::JointFactor(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                         std::size_t most)
    : pairings_(pairings), S_(S) {
  const auto rows = static_cast<Index>(2 * most);
  L_.resize(rows, rows);
  y_.resize(rows);
  entries_.reserve(most);
}

JointFactor::Addition JointFactor::put(std::size_t place, int pairing) {
  const bool is_there = place < entries_.size() && entries_[place].pairing == pairing;
  if (is_there) return entries_[place].addition;
  entries_.resize(place);
  entries_.push_back({pairing, compute(place, pairing)});
  return entries_.back().addition;
}

JointFactor::Addition JointFactor::compute(std::size_t place, int pairing) {
  const auto first = static_cast<Index>(2 * place);
  const Pairing& added = pairings_[static_cast<std::size_t>(pairing)];
  double distance2 = 0.0, deviations = 1.0;
  for (Index i = 0; i < 2; ++i) {
    const Index row = first + i;
    const Index S_column = 2 * Index{pairing} + i;  // S is symmetric, and stored by columns
    double* const l = L_.row(row).data();
    double innovation = added.innovation[i];
    for (Index j = 0; j < row; ++j) {
      const int other = j < first ? entries_[static_cast<std::size_t>(j / 2)].pairing : pairing;
      const double* const l_j = L_.row(j).data();
      double rest = S_(2 * Index{other} + j % 2, S_column);
      for (Index k = 0; k < j; ++k) rest -= l[k] * l_j[k];
      l[j] = rest / l_j[j];
      innovation -= l[j] * y_[j];
    }
    double variance = S_(S_column, S_column);
    for (Index k = 0; k < row; ++k) variance -= l[k] * l[k];
    if (!(variance > 0.0)) return {std::numeric_limits<double>::infinity(), 0.0};
    l[row] = std::sqrt(variance);
    y_[row] = innovation / l[row];
    distance2 += y_[row] * y_[row];
    deviations *= l[row];
  }
  return {distance2, std::log(deviations)};
}

}  // namespace hymm::core
