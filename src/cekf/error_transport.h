#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace hymm::core {

/// Where something was, and where it is.
struct Move {
  Eigen::Vector2d from, to;
};

/// By which angle [rad] things have turned about their centre (least squares); 0 for a single one.
double turnOf(const std::vector<Move>& moves);

/// How errors go along with a correction that moves and turns the map's parts by different amounts.
///
/// What the filter knows of two things that were seen together is how they lie to each other: an
/// error of the heading shifts the one against the other at right angles to the line between them.
/// If a correction turns that line, their errors have to turn with it, or the next observation
/// would find the old heading's error along the new line, where it measures it. So the DIFFERENCES
/// of errors of things that are tied turn with the things:
///   e_i' - e_j' = R_ij (e_i - e_j) + J (v_ij' - R_ij v_ij) * (their common error of the heading),
/// where v_ij is the line between them, R_ij its turn, and J turns by 90 degrees. The second term
/// is for what the line is stretched: it lets an error d of the heading of all, J * v_ij * d,
/// become J * v_ij' * d. Nothing can be learnt of it from how things lie to each other, before or
/// after.
///
/// There are more ties than unknowns: the e' are those that agree best. A tie weighs by the square
/// of how well it is known: a long one spans parts that turn by different angles. The place that is
/// known best is tied to the ground.
class ErrorTransport {
 public:
  /// Of the places in the rows `places` and the next of the states; the first is the vehicle's,
  /// whose heading is in row kHeading. Each is tied to those that `covariance` (of all states)
  /// knows it best to.
  ErrorTransport(std::vector<int> places, const Eigen::MatrixXd& covariance);
  ErrorTransport(const ErrorTransport&) = delete;
  ErrorTransport& operator=(const ErrorTransport&) = delete;

  static constexpr int kHeading = 2;

  /// By how much [rad] each place turns with those that it is tied to, if the states are moved by
  /// `moves`.
  Eigen::VectorXd turns(const Eigen::VectorXd& states, const Eigen::VectorXd& moves) const;

  /// e' = T * e, of all states; those that are no places keep their errors.
  class Map {
   public:
    Eigen::MatrixXd operator*(const Eigen::MatrixXd& errors) const;

   private:
    friend class ErrorTransport;
    explicit Map(const ErrorTransport& transport) : transport_(transport) {}

    const ErrorTransport& transport_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> G_[2];  ///< by coordinate: places x states
  };
  /// For a correction that moves `states` by `moves`. Lives no longer than this.
  Map mapAlong(const Eigen::VectorXd& states, const Eigen::VectorXd& moves) const;

 private:
  struct Tie {
    int other;
    double weight;  ///< 1 / m^4
  };
  using Row = Eigen::SparseVector<double>;

  Eigen::Vector2d at(const Eigen::VectorXd& states, int place) const {
    return states.segment<2>(places_[static_cast<std::size_t>(place)]);
  }
  int bestKnown(const Eigen::MatrixXd& covariance) const;
  void tie(const Eigen::MatrixXd& covariance);
  void addTie(int a, int b, double weight);
  void tieToBest(const Eigen::MatrixXd& weights);
  void tieAllTogether(int root, const Eigen::MatrixXd& weights);
  std::vector<Row> headings(const Eigen::VectorXd& states) const;

  std::vector<int> places_;
  std::vector<std::vector<Tie>> ties_;  ///< by place; each tie stands at both
  Eigen::VectorXd ground_;              ///< by place: weight of its tie to the ground
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> agreement_;
};

}  // namespace hymm::core
