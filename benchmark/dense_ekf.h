#pragma once

#include <vector>

#include <Eigen/Core>

namespace hymm::benchmarks {

/// The peer: an EKF over vehicle and landmarks with one dense covariance, as fast as it can be made
/// on one core. Of the covariance only the lower triangle is kept, the motion is carried to the
/// landmarks once a scan, Jacobians are sparse, and an update is one DSYRK.
class DenseEkf {
 public:
  /// A range-bearing measurement of one landmark.
  struct Measurement {
    Eigen::Vector2d innovation;
    Eigen::Matrix<double, 2, Eigen::Dynamic> H_vehicle;
    int landmark = 0;  ///< as append() numbered it
    Eigen::Matrix2d H_landmark;
    Eigen::Matrix2d noise;
  };

  /// Memory for `landmarks` landmarks is taken at once, so that none is ever copied.
  DenseEkf(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& covariance, int landmarks);

  void predict(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& J, const Eigen::MatrixXd& Q);
  /// False, and nothing changes, if the innovation covariance is not positive definite.
  bool update(const std::vector<Measurement>& measurements);
  /// A new landmark at g(vehicle, z), of Jacobian `G` by the vehicle's states.
  int append(const Eigen::Vector2d& position, const Eigen::Matrix<double, 2, Eigen::Dynamic>& G,
             const Eigen::Matrix2d& noise);

  int vehicleStates() const { return nv_; }
  int landmarkCount() const { return (n_ - nv_) / 2; }
  Eigen::VectorXd vehicle() const { return x_.head(nv_); }
  Eigen::Vector2d landmark(int index) const { return x_.segment<2>(rowOf(index)); }

 private:
  int rowOf(int landmark) const { return nv_ + 2 * landmark; }
  void flushMotion();
  Eigen::MatrixXd covarianceTimesMeasurements(const std::vector<Measurement>& measurements) const;

  int nv_;
  int n_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd P_;  ///< lower triangle; the vehicle's own block is whole
  Eigen::MatrixXd pending_J_;
};

}  // namespace hymm::benchmarks
