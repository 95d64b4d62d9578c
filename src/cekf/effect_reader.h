#pragma once

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
  /// For the pairs at `indices`.
  EffectReader(const TiledSymmetricMatrix& covariance, const Eigen::VectorXd& states,
               const IntervalEffect& effect, const std::vector<int>& indices);

  Eigen::Vector2d state(int index) const;
  Eigen::Matrix2d covariance(int index_a, int index_b) const;

 private:
  struct Pair {
    int row = -1;     ///< of the active part, or -1
    int column = -1;  ///< of W_ and T_, if passive
  };

  void gather(const std::vector<int>& passive);

  const TiledSymmetricMatrix& covariance_;
  const Eigen::VectorXd& states_;
  const IntervalEffect& effect_;
  std::unordered_map<int, Pair> pairs_;
  Eigen::MatrixXd W_;  ///< origins x passive states asked for
  Eigen::MatrixXd T_;  ///< F' * W
};

}  // namespace hymm::core
