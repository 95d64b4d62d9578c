#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/interval_effect.h"
#include "cekf/tiled_symmetric_matrix.h"

namespace hymm::core {

/// Pairs of states and their covariances as an interval leaves them, read beside a store that still
/// holds them as of the interval's start. Refers to all it is given.
class EffectReader {
 public:
  /// For the pairs at `indices`; a vehicle's state counts as the pair that it is in.
  EffectReader(const TiledSymmetricMatrix& covariance, const Eigen::VectorXd& states,
               const IntervalEffect& effect, const std::vector<int>& indices);
  /// After two intervals: `before` reads what the first leaves, of the pairs at `indices` and of
  /// all origins of the second, `effect`.
  EffectReader(const EffectReader& before, const IntervalEffect& effect,
               const std::vector<int>& indices);

  Eigen::Vector2d state(int index) const;
  Eigen::Matrix2d covariance(int index_a, int index_b) const;

 private:
  struct Pair {
    int row = -1;     ///< of the active part, or -1
    int column = -1;  ///< of W_ and T_, if passive
  };

  void sort(const std::vector<int>& indices);
  void gather();
  /// Covariance of single states.
  double entry(int a, int b) const;
  Pair placeOf(int state) const;

  std::function<double(int, int)> covariance_;  ///< of single states, at the interval's start
  std::function<Eigen::Vector2d(int)> state_;   ///< of a pair, likewise
  const IntervalEffect& effect_;
  std::unordered_map<int, Pair> pairs_;
  std::vector<int> passive_;  ///< pairs, in the order of their columns
  Eigen::MatrixXd W_;         ///< origins x passive states asked for
  Eigen::MatrixXd T_;         ///< F' * W
};

}  // namespace hymm::core
