#pragma once

#include <map>
#include <vector>

#include <Eigen/Dense>

namespace hymm::test {

/// The textbook EKF over vehicle and landmarks with one dense covariance and dense Jacobians,
/// written without the compressed filter's code. Landmarks are addressed by ids of the caller.
class FullEkf {
 public:
  struct Row {
    Eigen::Vector2d innovation;
    Eigen::MatrixXd H_vehicle;  // 2 x nv, or 2 x 0
    std::vector<std::pair<int, Eigen::Matrix2d>> H_landmarks;
    Eigen::Matrix2d noise;
  };

  FullEkf(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& covariance)
      : nv_(vehicle.size()), x_(vehicle), P_(covariance) {}

  void predict(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& J, const Eigen::MatrixXd& Q) {
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(x_.size(), x_.size());
    F.topLeftCorner(nv_, nv_) = J;
    P_ = F * P_ * F.transpose();
    P_.topLeftCorner(nv_, nv_) += Q;
    x_.head(nv_) = vehicle;
  }

  void update(const std::vector<Row>& rows) {
    const auto m = static_cast<Eigen::Index>(2 * rows.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m, x_.size());
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(m, m);
    Eigen::VectorXd z(m);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto r = static_cast<Eigen::Index>(2 * k);
      if (rows[k].H_vehicle.cols() > 0) H.block(r, 0, 2, nv_) = rows[k].H_vehicle;
      for (const auto& [id, block] : rows[k].H_landmarks) H.block<2, 2>(r, index(id)) += block;
      R.block<2, 2>(r, r) = rows[k].noise;
      z.segment<2>(r) = rows[k].innovation;
    }
    const Eigen::MatrixXd S = H * P_ * H.transpose() + R;
    const Eigen::MatrixXd K = P_ * H.transpose() * S.inverse();
    x_ += K * z;
    const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(x_.size(), x_.size());
    P_ = (I - K * H) * P_ * (I - K * H).transpose() + K * R * K.transpose();
    P_ = 0.5 * (P_ + P_.transpose()).eval();
  }

  /// `other`: id of a landmark on which the new one depends as well, or -1.
  void append(int id, const Eigen::Vector2d& position, const Eigen::MatrixXd& G,
              const Eigen::Matrix2d& noise, int other = -1,
              const Eigen::Matrix2d& G_other = Eigen::Matrix2d::Zero()) {
    const Eigen::Index n = x_.size();
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n + 2, n);
    T.topRows(n).setIdentity();
    T.block(n, 0, 2, nv_) = G;
    if (other >= 0) T.block<2, 2>(n, index(other)) = G_other;
    P_ = (T * P_ * T.transpose()).eval();
    P_.bottomRightCorner<2, 2>() += noise;
    x_.conservativeResize(n + 2);
    x_.tail<2>() = position;
    index_[id] = n;
  }

  void remove(int id) {
    const Eigen::Index gone = index(id), n = x_.size();
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n - 2, n);
    for (Eigen::Index r = 0; r < n - 2; ++r) T(r, r < gone ? r : r + 2) = 1.0;
    x_ = (T * x_).eval();
    P_ = (T * P_ * T.transpose()).eval();
    index_.erase(id);
    for (auto& [other, place] : index_) {
      if (place > gone) place -= 2;
    }
  }

  void initialiseVehicleStates(Eigen::Index first, const Eigen::VectorXd& value,
                               const Eigen::MatrixXd& G, const Eigen::MatrixXd& noise) {
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(x_.size(), x_.size());
    T.middleRows(first, value.size()).setZero();
    T.block(first, 0, value.size(), nv_) = G;
    P_ = (T * P_ * T.transpose()).eval();
    P_.block(first, first, value.size(), value.size()) += noise;
    x_.segment(first, value.size()) = value;
  }

  void addVehicleError(int id, const Eigen::Vector2d& gain, Eigen::Index vehicle_state) {
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(x_.size(), x_.size());
    T.block<2, 1>(index(id), vehicle_state) = gain;
    P_ = (T * P_ * T.transpose()).eval();
  }

  void redefineErrors(const Eigen::MatrixXd& T) { P_ = (T * P_ * T.transpose()).eval(); }

  void addRigidNoise(const std::vector<int>& ids, const Eigen::Matrix3d& noise) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(x_.size(), 3);
    A.topRows<3>().setIdentity();
    for (const int id : ids) {
      const Eigen::Index i = index(id);
      A(i, 0) = A(i + 1, 1) = 1.0;
      A(i, 2) = x_[1] - x_[i + 1];
      A(i + 1, 2) = x_[i] - x_[0];
    }
    P_ += A * noise * A.transpose();
  }

  void fade(int id, double kept, const Eigen::Matrix2d& stationary) {
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(x_.size(), x_.size());
    T.block<2, 2>(index(id), index(id)) *= kept;
    x_ = (T * x_).eval();
    P_ = (T * P_ * T.transpose()).eval();
    P_.block<2, 2>(index(id), index(id)) += (1.0 - kept * kept) * stationary;
  }

  Eigen::Index index(int id) const { return index_.at(id); }
  const std::map<int, Eigen::Index>& landmarks() const { return index_; }
  const Eigen::VectorXd& state() const { return x_; }
  const Eigen::MatrixXd& covariance() const { return P_; }
  Eigen::Index vehicleStates() const { return nv_; }

 private:
  Eigen::Index nv_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd P_;
  std::map<int, Eigen::Index> index_;
};

}  // namespace hymm::test
