#include "cekf/error_transport.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "common/quarter_turn.h"

namespace hymm::core {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using Triplets = std::vector<Eigen::Triplet<double>>;

// Ties of a place: two would do if none were in line with it, and none badly known.
constexpr std::size_t kTies = 6;

// What is known better or worse counts as known so well [m^2]: weights within eight decimal digits,
// so that seven are left of the result.
constexpr double kLeastVariance = 0.01, kMostVariance = 100.0;

// Moment of a place's ties below which they do not tell its heading: one of 1 m, known to 10 m.
constexpr double kLeastMoment = 0.01;

// A line between places that changes by less than this share of itself tells its own turn; where
// they come upon each other, their ties tell.
constexpr double kLine = 0.1;

/// Of a tie between the places in rows a and b.
double weightOf(int a, int b, const MatrixXd& P) {
  double variance = 0.0;
  for (int i = 0; i < 2; ++i) {
    variance += P(a + i, a + i) + P(b + i, b + i) - 2.0 * P(a + i, b + i);
  }
  const double bounded = std::clamp(variance, kLeastVariance, kMostVariance);
  return 1.0 / (bounded * bounded);
}

/// A line that hardly changes tells its own turn; else it is `otherwise_rad`.
Matrix2d turnOfTie(const Vector2d& line, const Vector2d& line_to, double otherwise_rad) {
  const bool is_line = (line_to - line).norm() < kLine * line.norm();
  const double turn_rad =
      is_line ? turnOf({{Vector2d::Zero(), Vector2d::Zero()}, {line, line_to}}) : otherwise_rad;
  return Eigen::Rotation2Dd(turn_rad).toRotationMatrix();
}

/// What the ties say of each place's error, before it is shared out, as a matrix that is multiplied
/// with all errors.
class Gains {
 public:
  /// `headings`: by place, see ErrorTransport::headings().
  Gains(const std::vector<int>& places, std::vector<Eigen::SparseVector<double>> headings)
      : places_(places), headings_(std::move(headings)) {}

  void addError(int place, int of, const Matrix2d& gain) {
    const int column = places_[static_cast<std::size_t>(of)];
    for (int k = 0; k < 2; ++k) {
      for (int j = 0; j < 2; ++j) entries[k].emplace_back(place, column + j, gain(k, j));
    }
  }

  void addHeading(int place, int of, const Vector2d& gain) {
    const auto& heading = headings_[static_cast<std::size_t>(of)];
    for (Eigen::SparseVector<double>::InnerIterator entry(heading); entry; ++entry) {
      for (int k = 0; k < 2; ++k) {
        entries[k].emplace_back(place, static_cast<int>(entry.index()), gain[k] * entry.value());
      }
    }
  }

  Triplets entries[2];  ///< by coordinate

 private:
  const std::vector<int>& places_;
  std::vector<Eigen::SparseVector<double>> headings_;
};

}  // namespace

double turnOf(const std::vector<Move>& moves) {
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const Move& move : moves) {
    from += move.from / static_cast<double>(moves.size());
    to += move.to / static_cast<double>(moves.size());
  }
  double dot = 0.0, cross = 0.0;
  for (const Move& move : moves) {
    const Vector2d before = move.from - from, after = move.to - to;
    dot += before.dot(after);
    cross += before.x() * after.y() - before.y() * after.x();
  }
  return moves.size() < 2 ? 0.0 : std::atan2(cross, dot);
}

ErrorTransport::ErrorTransport(std::vector<int> places, const MatrixXd& covariance)
    : places_(std::move(places)), ties_(places_.size()), ground_(places_.size()) {
  tie(covariance);
  Triplets weights;
  for (int i = 0; i < ground_.size(); ++i) {
    weights.emplace_back(i, i, ground_[i]);
    for (const Tie& tie : ties_[static_cast<std::size_t>(i)]) {
      weights.emplace_back(i, i, tie.weight);
      weights.emplace_back(i, tie.other, -tie.weight);
    }
  }
  Eigen::SparseMatrix<double> sum(ground_.size(), ground_.size());
  sum.setFromTriplets(weights.begin(), weights.end());
  agreement_.compute(sum);
}

int ErrorTransport::bestKnown(const MatrixXd& P) const {
  const auto variance = [&P](int row) { return P(row, row) + P(row + 1, row + 1); };
  const auto best = std::min_element(places_.begin(), places_.end(),
                                     [&](int a, int b) { return variance(a) < variance(b); });
  return static_cast<int>(best - places_.begin());
}

void ErrorTransport::tie(const MatrixXd& P) {
  const int n = static_cast<int>(places_.size());
  MatrixXd weights(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      weights(i, j) =
          weightOf(places_[static_cast<std::size_t>(i)], places_[static_cast<std::size_t>(j)], P);
    }
  }
  const int ground = bestKnown(P);
  ground_.setZero();
  ground_[ground] = 1.0;
  tieToBest(weights);
  tieAllTogether(ground, weights);
}

void ErrorTransport::addTie(int a, int b, double weight) {
  auto& ties = ties_[static_cast<std::size_t>(a)];
  const auto is_same = [b](const Tie& tie) { return tie.other == b; };
  if (std::any_of(ties.begin(), ties.end(), is_same)) return;
  ties.push_back({b, weight});
  ties_[static_cast<std::size_t>(b)].push_back({a, weight});
}

void ErrorTransport::tieToBest(const MatrixXd& weights) {
  const int n = static_cast<int>(weights.rows());
  std::vector<int> others;
  for (int i = 0; i < n; ++i) {
    others.clear();
    for (int j = 0; j < n; ++j) {
      if (j != i) others.push_back(j);
    }
    const auto last = others.begin() + static_cast<std::ptrdiff_t>(std::min(kTies, others.size()));
    std::partial_sort(others.begin(), last, others.end(), [&](int a, int b) {
      return weights(i, a) != weights(i, b) ? weights(i, a) > weights(i, b) : a < b;
    });
    for (auto other = others.begin(); other != last; ++other) addTie(i, *other, weights(i, *other));
  }
}

/// Groups whose best ties are all among themselves: by the best tree (Prim's).
void ErrorTransport::tieAllTogether(int root, const MatrixXd& weights) {
  VectorXd best = weights.col(root);  // tie of each to the tree; negative: it is in there
  std::vector<int> to(static_cast<std::size_t>(best.size()), root);
  best[root] = -1.0;
  for (Eigen::Index count = 1; count < best.size(); ++count) {
    Eigen::Index next = 0;
    const double weight = best.maxCoeff(&next);
    addTie(static_cast<int>(next), to[static_cast<std::size_t>(next)], weight);
    best[next] = -1.0;
    for (Eigen::Index k = 0; k < best.size(); ++k) {
      if (best[k] < 0.0 || weights(k, next) <= best[k]) continue;
      best[k] = weights(k, next);
      to[static_cast<std::size_t>(k)] = static_cast<int>(next);
    }
  }
}

VectorXd ErrorTransport::turns(const VectorXd& states, const VectorXd& moves) const {
  VectorXd turns(ground_.size());
  turns[0] = moves[kHeading];
  std::vector<Move> near;
  for (int i = 1; i < turns.size(); ++i) {
    near.assign(1, {at(states, i), at(states, i) + at(moves, i)});
    for (const Tie& tie : ties_[static_cast<std::size_t>(i)]) {
      near.push_back({at(states, tie.other), at(states, tie.other) + at(moves, tie.other)});
    }
    turns[i] = turnOf(near);
  }
  return turns;
}

/// By place, as a row that is multiplied with all errors: the error of the heading of the place and
/// what it is tied to, as a body.
std::vector<ErrorTransport::Row> ErrorTransport::headings(const VectorXd& states) const {
  const auto size = states.size();
  Row vehicle(size);
  vehicle.insert(kHeading) = 1.0;
  std::vector<Row> headings(places_.size(), vehicle);
  for (int i = 1; i < ground_.size(); ++i) {
    Row row(size);
    double moment = 0.0;
    for (const Tie& tie : ties_[static_cast<std::size_t>(i)]) {
      const Vector2d arm = at(states, i) - at(states, tie.other);
      const Vector2d gain = tie.weight * turnedLeft(arm);
      moment += tie.weight * arm.squaredNorm();
      for (int k = 0; k < 2; ++k) {
        row.coeffRef(places_[static_cast<std::size_t>(i)] + k) += gain[k];
        row.coeffRef(places_[static_cast<std::size_t>(tie.other)] + k) -= gain[k];
      }
    }
    if (moment > kLeastMoment) headings[static_cast<std::size_t>(i)] = row / moment;
  }
  return headings;
}

ErrorTransport::Map ErrorTransport::mapAlong(const VectorXd& states, const VectorXd& moves) const {
  const VectorXd turned = turns(states, moves);
  Gains gains(places_, headings(states));
  for (int i = 0; i < ground_.size(); ++i) {
    const Matrix2d own = Eigen::Rotation2Dd(turned[i]).toRotationMatrix();
    gains.addError(i, i, ground_[i] * own);
    const Vector2d to = at(states, i) + at(moves, i);
    gains.addHeading(i, i, ground_[i] * turnedLeft(to - own * at(states, i)));
    for (const Tie& tie : ties_[static_cast<std::size_t>(i)]) {
      const Vector2d line = at(states, i) - at(states, tie.other);
      const Vector2d line_to = line + at(moves, i) - at(moves, tie.other);
      const Matrix2d R = turnOfTie(line, line_to, 0.5 * (turned[i] + turned[tie.other]));
      gains.addError(i, i, tie.weight * R);
      gains.addError(i, tie.other, -tie.weight * R);
      const Vector2d stretched = tie.weight * turnedLeft(line_to - R * line);
      // What the vehicle sees, it sees with its own heading's error.
      const bool is_seen = i == 0 || tie.other == 0;
      gains.addHeading(i, is_seen ? 0 : i, 0.5 * stretched);
      gains.addHeading(i, is_seen ? 0 : tie.other, 0.5 * stretched);
    }
  }
  Map map(*this);
  for (int k = 0; k < 2; ++k) {
    map.G_[k].resize(ground_.size(), states.size());
    map.G_[k].setFromTriplets(gains.entries[k].begin(), gains.entries[k].end());
  }
  return map;
}

MatrixXd ErrorTransport::Map::operator*(const MatrixXd& errors) const {
  MatrixXd result = errors;
  for (int k = 0; k < 2; ++k) {
    const MatrixXd sum = G_[k] * errors;
    const MatrixXd agreed = transport_.agreement_.solve(sum);
    for (std::size_t i = 0; i < transport_.places_.size(); ++i) {
      result.row(transport_.places_[i] + k) = agreed.row(static_cast<Eigen::Index>(i));
    }
  }
  return result;
}

}  // namespace hymm::core
