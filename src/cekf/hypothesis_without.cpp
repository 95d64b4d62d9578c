#include "cekf/hypothesis_without.h"

#include <Eigen/Cholesky>

namespace hymm::core {

using Eigen::Index;

HypothesisWithout::HypothesisWithout(const std::vector<Pairing>& pairings, const Eigen::MatrixXd& S,
                                     const std::vector<int>& chosen)
    : left_out_(weighted_, A_, chosen.size()) {
  const auto n = static_cast<Index>(chosen.size());
  A_.resize(2 * n, 2 * n);
  Eigen::VectorXd innovations(2 * n);
  for (Index i = 0; i < n; ++i) {
    const int pairing = chosen[static_cast<std::size_t>(i)];
    place_of_[pairing] = static_cast<int>(i);
    weighted_.push_back(pairings[static_cast<std::size_t>(pairing)]);
    innovations.segment<2>(2 * i) = weighted_.back().innovation;
    for (Index j = 0; j < n; ++j) {
      A_.block<2, 2>(2 * i, 2 * j) =
          S.block<2, 2>(2 * pairing, 2 * chosen[static_cast<std::size_t>(j)]);
    }
  }
  A_ = Eigen::LLT<Eigen::MatrixXd>(A_).solve(Eigen::MatrixXd::Identity(2 * n, 2 * n));
  const Eigen::VectorXd y = A_ * innovations;
  for (Index i = 0; i < n; ++i) {
    weighted_[static_cast<std::size_t>(i)].innovation = y.segment<2>(2 * i);
  }
  distances2_.push_back(innovations.dot(y));
}

void HypothesisWithout::leaveOut(int pairing) {
  const std::size_t before = distances2_.size() - 1;
  const JointFactor::Addition added = left_out_.put(before, place_of_.at(pairing));
  distances2_.push_back(distance2() - added.distance2);
}

}  // namespace hymm::core
