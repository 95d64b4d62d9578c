#include "cekf/effect_reader.h"

#include "cekf/blas.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

EffectReader::EffectReader(const TiledSymmetricMatrix& covariance, const Eigen::VectorXd& states,
                           const IntervalEffect& effect, const std::vector<int>& indices)
    : covariance_(covariance), states_(states), effect_(effect) {
  std::unordered_map<int, int> active_rows;
  for (std::size_t row = 0; row < effect.active.size(); ++row) {
    active_rows[effect.active[row]] = static_cast<int>(row);
  }
  std::vector<int> passive;
  for (const int index : indices) {
    Pair& pair = pairs_[index];
    const auto active = active_rows.find(index);
    if (active != active_rows.end()) {
      pair.row = active->second;
    } else if (pair.column < 0) {
      pair.column = 2 * static_cast<int>(passive.size());
      passive.push_back(index);
    }
  }
  gather(passive);
}

void EffectReader::gather(const std::vector<int>& passive) {
  const auto origins = static_cast<int>(effect_.origins.size());
  const auto columns = 2 * static_cast<int>(passive.size());
  W_.resize(origins, columns);
  for (int column = 0; column < columns; ++column) {
    const int index = passive[static_cast<std::size_t>(column / 2)] + column % 2;
    for (int k = 0; k < origins; ++k) {
      W_(k, column) = covariance_(effect_.origins[static_cast<std::size_t>(k)], index);
    }
  }
  const Eigen::MatrixXd F = factorOf(effect_.psi);
  T_.setZero(origins, columns);
  blas::gemm(true, false, origins, columns, origins, 1.0, F.data(), origins, W_.data(), origins,
             T_.data(), origins);
}

Vector2d EffectReader::state(int index) const {
  const Pair& pair = pairs_.at(index);
  if (pair.row >= 0) return effect_.x.segment<2>(pair.row);
  return states_.segment<2>(index) + W_.middleCols<2>(pair.column).transpose() * effect_.theta;
}

Matrix2d EffectReader::covariance(int index_a, int index_b) const {
  const Pair &a = pairs_.at(index_a), &b = pairs_.at(index_b);
  if (a.row >= 0 && b.row >= 0) return effect_.P.block<2, 2>(a.row, b.row);
  if (a.row >= 0) return effect_.phi.middleRows<2>(a.row) * W_.middleCols<2>(b.column);
  if (b.row >= 0) return covariance(index_b, index_a).transpose();
  Matrix2d block;
  block << covariance_(index_a, index_b), covariance_(index_a, index_b + 1),
      covariance_(index_a + 1, index_b), covariance_(index_a + 1, index_b + 1);
  return block - T_.middleCols<2>(a.column).transpose() * T_.middleCols<2>(b.column);
}

}  // namespace hymm::core
