#include "cekf/effect_reader.h"

#include "cekf/blas.h"

namespace hymm::core {

using Eigen::Matrix2d;
using Eigen::Vector2d;

EffectReader::EffectReader(const TiledSymmetricMatrix& covariance, const Eigen::VectorXd& states,
                           const IntervalEffect& effect, const std::vector<int>& indices)
    : covariance_([&covariance](int a, int b) { return covariance(a, b); }),
      state_([&states](int index) -> Vector2d { return states.segment<2>(index); }),
      effect_(effect) {
  sort(indices);
  gather();
}

EffectReader::EffectReader(const EffectReader& before, const IntervalEffect& effect,
                           const std::vector<int>& indices)
    : covariance_([&before](int a, int b) { return before.entry(a, b); }),
      state_([&before](int index) { return before.state(index); }),
      effect_(effect) {
  sort(indices);
  gather();
}

void EffectReader::sort(const std::vector<int>& indices) {
  std::unordered_map<int, int> active_rows;
  for (std::size_t row = 0; row < effect_.active.size(); ++row) {
    active_rows[effect_.active[row]] = static_cast<int>(row);
  }
  for (const int any : indices) {
    const int index = any - any % 2;
    Pair& pair = pairs_[index];
    const auto active = active_rows.find(index);
    if (active != active_rows.end()) {
      pair.row = active->second;
    } else if (pair.column < 0) {
      pair.column = 2 * static_cast<int>(passive_.size());
      passive_.push_back(index);
    }
  }
}

void EffectReader::gather() {
  const auto origins = static_cast<int>(effect_.origins.size());
  const auto columns = 2 * static_cast<int>(passive_.size());
  W_.resize(origins, columns);
  for (int column = 0; column < columns; ++column) {
    const int index = passive_[static_cast<std::size_t>(column / 2)] + column % 2;
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
  return state_(index) + W_.middleCols<2>(pair.column).transpose() * effect_.theta;
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

EffectReader::Pair EffectReader::placeOf(int state) const {
  Pair place = pairs_.at(state - state % 2);
  (place.row >= 0 ? place.row : place.column) += state % 2;
  return place;
}

double EffectReader::entry(int a, int b) const {
  const Pair place_a = placeOf(a), place_b = placeOf(b);
  if (place_a.row >= 0 && place_b.row >= 0) return effect_.P(place_a.row, place_b.row);
  if (place_a.row >= 0) return effect_.phi.row(place_a.row).dot(W_.col(place_b.column));
  if (place_b.row >= 0) return entry(b, a);
  return covariance_(a, b) - T_.col(place_a.column).dot(T_.col(place_b.column));
}

}  // namespace hymm::core
