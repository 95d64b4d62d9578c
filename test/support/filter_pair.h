#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "cekf/compressed_ekf.h"
#include "support/full_ekf.h"

namespace hymm::test {

/// How far two filters are apart, and whether the first one's covariance is one.
struct FilterDifference {
  double covariance = 0.0;        ///< max |dP_ij| / sqrt(P_ii * P_jj)
  double state = 0.0;             ///< max |dx_i| / sqrt(P_ii)
  double asymmetry = 0.0;         ///< max |P_ij - P_ji| / sqrt(P_ii * P_jj)
  double least_eigenvalue = 0.0;  ///< as a share of the greatest
};

/// The compressed filter and the textbook one, told the same things. Landmarks have ids.
class FilterPair {
 public:
  using Row = FullEkf::Row;

  /// `arguments` are further ones of the compressed filter's constructor.
  template <typename... Arguments>
  FilterPair(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& covariance,
             Arguments... arguments)
      : compressed_(vehicle, covariance, arguments...), full_(vehicle, covariance) {}

  core::CompressedEkf& compressed() { return compressed_; }
  const core::CompressedEkf& compressed() const { return compressed_; }
  FullEkf& full() { return full_; }
  const FullEkf& full() const { return full_; }

  /// Slots in the compressed filter by id.
  const std::map<int, int>& slots() const { return slots_; }

  /// New landmark; each filter may have its own linearisation. Returns its id.
  int append(const Eigen::Vector2d& compressed_position, const Eigen::MatrixXd& compressed_G,
             const Eigen::Matrix2d& compressed_noise, const Eigen::Vector2d& full_position,
             const Eigen::MatrixXd& full_G, const Eigen::Matrix2d& full_noise) {
    slots_[next_id_] = compressed_.append(compressed_position, compressed_G, compressed_noise);
    full_.append(next_id_, full_position, full_G, full_noise);
    return next_id_++;
  }
  int append(const Eigen::Vector2d& position, const Eigen::MatrixXd& G,
             const Eigen::Matrix2d& noise) {
    return append(position, G, noise, position, G, noise);
  }

  /// The same; it depends on landmark `other` as well.
  int append(const Eigen::Vector2d& position, const Eigen::MatrixXd& G,
             const Eigen::Matrix2d& noise, int other, const Eigen::Matrix2d& G_other) {
    compressed_.activate(slots_.at(other));
    slots_[next_id_] = compressed_.append(position, G, noise, {slots_.at(other), G_other});
    full_.append(next_id_, position, G, noise, other, G_other);
    return next_id_++;
  }
  /// Two states that depend on nothing.
  int appendQuantities(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance) {
    slots_[next_id_] = compressed_.appendQuantities(mean, covariance);
    full_.append(next_id_, mean, Eigen::MatrixXd::Zero(2, full_.vehicleStates()), covariance);
    return next_id_++;
  }

  void remove(int id) {
    compressed_.remove(slots_.at(id));
    full_.remove(id);
    slots_.erase(id);
  }

  /// e <- T * e, of the vehicle's states and the landmarks in `ids`, in this order.
  void redefineErrors(const std::vector<int>& ids, const Eigen::MatrixXd& T) {
    for (const int id : ids) compressed_.activate(slots_.at(id));
    const auto rowsOf = [&](auto&& first) {
      std::vector<Eigen::Index> rows;
      for (Eigen::Index k = 0; k < full_.vehicleStates(); ++k) rows.push_back(k);
      for (const int id : ids) rows.insert(rows.end(), {first(id), first(id) + 1});
      return rows;
    };
    const auto among = [&T](const std::vector<Eigen::Index>& rows, Eigen::Index size) {
      Eigen::MatrixXd all = Eigen::MatrixXd::Identity(size, size);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t j = 0; j < rows.size(); ++j) {
          all(rows[i], rows[j]) = T(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
      return all;
    };
    const Eigen::MatrixXd active =
        among(rowsOf([&](int id) { return Eigen::Index{compressed_.activeRow(slots_.at(id))}; }),
              compressed_.activeStates().size());
    compressed_.redefineErrors([&](const Eigen::MatrixXd& errors) { return active * errors; });
    full_.redefineErrors(
        among(rowsOf([&](int id) { return full_.index(id); }), full_.state().size()));
  }

  void addVehicleError(int id, const Eigen::Vector2d& gain, int vehicle_state) {
    compressed_.activate(slots_.at(id));
    compressed_.addVehicleError(slots_.at(id), gain, vehicle_state);
    full_.addVehicleError(id, gain, vehicle_state);
  }

  void addRigidNoise(const std::vector<int>& ids, const Eigen::Matrix3d& noise) {
    std::vector<int> slots;
    for (const int id : ids) {
      slots.push_back(slots_.at(id));
      compressed_.activate(slots.back());
    }
    compressed_.addRigidNoise(slots, noise);
    full_.addRigidNoise(ids, noise);
  }

  void fade(int id, double kept, const Eigen::Matrix2d& stationary) {
    compressed_.activate(slots_.at(id));
    compressed_.fade(slots_.at(id), kept, stationary);
    full_.fade(id, kept, stationary);
  }

  void update(const std::vector<Row>& compressed_rows, const std::vector<Row>& full_rows) {
    std::vector<core::SparseMeasurement> measurements;
    for (const Row& row : compressed_rows) measurements.push_back(sparse(row));
    compressed_.update(measurements);
    full_.update(full_rows);
  }
  void update(const std::vector<Row>& rows) { update(rows, rows); }

  /// Compares everything: vehicle, all landmarks, active or not, all covariances.
  FilterDifference difference() const {
    const Eigen::VectorXd x = compressedState();
    const Eigen::MatrixXd P = compressedCovariance();
    const Eigen::VectorXd sigma = full_.covariance().diagonal().cwiseMax(0.0).cwiseSqrt();
    FilterDifference d;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      d.state = std::max(d.state, share(x[i] - full_.state()[i], sigma[i]));
      for (Eigen::Index j = 0; j < x.size(); ++j) {
        const double unit = sigma[i] * sigma[j];
        d.covariance = std::max(d.covariance, share(P(i, j) - full_.covariance()(i, j), unit));
        d.asymmetry = std::max(d.asymmetry, share(P(i, j) - P(j, i), unit));
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(P, Eigen::EigenvaluesOnly);
    d.least_eigenvalue = solver.eigenvalues().minCoeff() / solver.eigenvalues().maxCoeff();
    return d;
  }

 private:
  /// A difference in units of a deviation; what is known exactly must be equal.
  static double share(double difference, double unit) {
    if (difference == 0.0) return 0.0;
    return unit > 0.0 ? std::abs(difference) / unit : std::numeric_limits<double>::infinity();
  }

  core::SparseMeasurement sparse(const Row& row) {
    core::SparseMeasurement measurement;
    measurement.innovation = row.innovation;
    measurement.H_vehicle = row.H_vehicle;
    measurement.noise = row.noise;
    for (std::size_t k = 0; k < row.H_landmarks.size(); ++k) {
      measurement.landmarks[k] = slots_.at(row.H_landmarks[k].first);
      measurement.H_landmarks[k] = row.H_landmarks[k].second;
      compressed_.activate(measurement.landmarks[k]);
    }
    return measurement;
  }

  /// In the order of the full filter.
  Eigen::VectorXd compressedState() const {
    Eigen::VectorXd x(full_.state().size());
    x.head(full_.vehicleStates()) = compressed_.vehicle();
    for (const auto& [id, slot] : slots_) {
      x.segment<2>(full_.index(id)) = compressed_.landmark(slot);
    }
    return x;
  }

  Eigen::MatrixXd compressedCovariance() const {
    const Eigen::Index nv = full_.vehicleStates(), n = full_.state().size();
    Eigen::MatrixXd P(n, n);
    P.topLeftCorner(nv, nv) = compressed_.vehicleCovariance();
    for (const auto& [id, slot] : slots_) {
      const Eigen::Index i = full_.index(id);
      P.block(0, i, nv, 2) = compressed_.vehicleLandmarkCovariance(slot);
      P.block(i, 0, 2, nv) = P.block(0, i, nv, 2).transpose();
      for (const auto& [other_id, other_slot] : slots_) {
        P.block<2, 2>(i, full_.index(other_id)) = compressed_.covariance(slot, other_slot);
      }
    }
    return P;
  }

  core::CompressedEkf compressed_;
  FullEkf full_;
  std::map<int, int> slots_;
  int next_id_ = 0;
};

}  // namespace hymm::test
