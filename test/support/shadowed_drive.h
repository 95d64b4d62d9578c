#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "cekf/observation_model.h"
#include "common/random.h"
#include "simulation/simulation_config.h"
#include "support/filter_pair.h"
#include "vehicle/motion_model.h"

namespace hymm::test {

/// A car that wanders among landmarks, with the compressed filter and, as its shadow, the textbook
/// one. Both get the same odometry, observations, associations and GPS fixes, and each linearises
/// at its own estimate. Landmarks come when they are first seen and go at random; calibration is
/// estimated; a GPS datum enters the state on the way; a global update runs whenever the car leaves
/// its cell.
class ShadowedDrive {
 public:
  template <typename... Arguments>
  explicit ShadowedDrive(std::uint64_t seed, Arguments... arguments)
      : generator_(seed),
        model_(core::simulatedCar()),
        filters_(initialState(), initialCovariance(), arguments...) {
    for (int i = 0; i < kLandmarks; ++i) {
      world_.emplace_back(core::sampleUniform(generator_, -kHalfSide_m, kHalfSide_m),
                          core::sampleUniform(generator_, -kHalfSide_m, kHalfSide_m));
    }
  }

  /// One scan period. True when it ended with the start of a global update.
  bool step() {
    ++steps_;
    move();
    if (steps_ == kDatumStep) alignWithGps();
    if (steps_ > kDatumStep && chance(0.1)) fixPosition();
    if (chance(0.03)) removeAny();
    observe();
    return leaveCell();
  }

  FilterPair& filters() { return filters_; }
  const FilterPair& filters() const { return filters_; }
  /// Distance of the estimate from the truth [m].
  double positionError() const {
    return (filters_.compressed().vehicle().head<2>() - truth_.position()).norm();
  }

 private:
  static constexpr int kLandmarks = 90;
  static constexpr double kHalfSide_m = 100.0;
  static constexpr double kCell_m = 30.0;
  static constexpr double kRange_m = 28.0;
  static constexpr double kPeriod_s = 0.214;
  static constexpr int kDatumStep = 50;
  // States: pose, errors (speed, turn), calibration (speed scale, turn scale, turn offset),
  // T_map_enu.
  static constexpr int kError = 3, kCalibration = 5, kDatum = 8, kStates = 11;

  /// What a row is linearised at: one of the two filters.
  struct Estimate {
    Eigen::VectorXd vehicle;
    std::map<int, Eigen::Vector2d> landmarks;  // those asked for, by id
    core::Pose2 pose() const { return core::Pose2::fromVector(vehicle.head<3>()); }
  };

  static Eigen::VectorXd initialState() {
    Eigen::VectorXd state = Eigen::VectorXd::Zero(kStates);
    state.segment<3>(kCalibration) = core::Calibration{}.vector();
    return state;
  }
  static Eigen::MatrixXd initialCovariance() {
    Eigen::VectorXd deviations = Eigen::VectorXd::Zero(kStates);
    deviations.segment<2>(kError).setOnes();
    deviations.segment<3>(kCalibration) << 0.02, 0.02, 0.01;
    return deviations.cwiseAbs2().asDiagonal();
  }

  bool chance(double share) { return core::sampleUniform(generator_, 0.0, 1.0) < share; }
  Eigen::Vector2d normal2(double first, double second) {
    const double a = core::sampleNormal(generator_, first);
    return {a, core::sampleNormal(generator_, second)};
  }

  Estimate compressedEstimate() const {
    Estimate estimate{filters_.compressed().vehicle(), {}};
    for (const auto& [id, slot] : filters_.slots()) {
      estimate.landmarks[id] = filters_.compressed().landmark(slot);
    }
    return estimate;
  }
  Estimate fullEstimate() const {
    const FullEkf& full = filters_.full();
    Estimate estimate{full.state().head(kStates), {}};
    for (const auto& [id, index] : full.landmarks()) {
      estimate.landmarks[id] = full.state().segment<2>(index);
    }
    return estimate;
  }

  // --- Motion ---------------------------------------------------------------------------------
  void move() {
    // Back to the middle when the border comes near, else as it likes.
    const double home = std::atan2(-truth_.y_m, -truth_.x_m);
    const bool far = truth_.position().cwiseAbs().maxCoeff() > kHalfSide_m - 15.0;
    const double wish =
        far ? core::wrapAngle(home - truth_.yaw_rad) : core::sampleNormal(generator_, 0.5);
    const double yaw_rate = std::max(-0.6, std::min(0.6, wish));
    const core::TwistInput measured{0.0, 5.0, 0.0, yaw_rate, std::nullopt};
    const core::Calibration true_calibration{1.02, 0.97, 0.005};
    truth_ = model_.step(truth_, measured, true_calibration, 0.0, kPeriod_s).pose;
    predict(measured, filters_.compressed(), filters_.compressed().vehicle());
    predict(measured, filters_.full(), filters_.full().state().head(kStates));
  }

  template <typename Filter>
  void predict(const core::TwistInput& input, Filter& filter, Eigen::VectorXd state) {
    const core::MotionStep step =
        model_.step(core::Pose2::fromVector(state.head<3>()), input,
                    core::Calibration::fromVector(state.segment<3>(kCalibration)), 0.0, kPeriod_s,
                    {state[kError], state[kError + 1], 0.0});
    const Eigen::Array2d kept = (-kPeriod_s / model_.correlationTimes().head<2>().array()).exp();
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(kStates, kStates);
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(kStates, kStates);
    J.topLeftCorner<3, 3>() = step.J_pose;
    J.block<3, 2>(0, kError) = step.J_error.leftCols<2>();
    J.diagonal().segment<2>(kError) = kept;
    J.block<3, 3>(0, kCalibration) = step.J_calibration;
    Q.topLeftCorner<3, 3>() = step.whiteNoise(Eigen::Vector3d::Ones());
    Q.diagonal().segment<2>(kError) = 1.0 - kept.square();
    state.head<3>() = step.pose.vector();
    state.segment<2>(kError).array() *= kept;
    filter.predict(state, J, Q);
  }

  // --- Landmarks ------------------------------------------------------------------------------
  struct Sighting {
    std::size_t place;  // in the world
    Eigen::Vector2d value;
  };

  void observe() {
    const Eigen::Matrix2d noise = Eigen::Vector2d(0.05 * 0.05, 0.005 * 0.005).asDiagonal();
    std::vector<Sighting> known, fresh;
    for (std::size_t i = 0; i < world_.size(); ++i) {
      const core::RangeBearing z = core::predictRangeBearing(truth_, kSensor, world_[i]);
      if (z.value[0] > kRange_m || std::abs(z.value[1]) > core::kPi / 2.0 || chance(0.05)) continue;
      (id_of_place_.count(i) > 0 ? known : fresh).push_back({i, z.value + normal2(0.05, 0.005)});
    }
    if (!known.empty()) {
      filters_.update(rows(known, noise, compressedEstimate()), rows(known, noise, fullEstimate()));
    }
    for (const Sighting& sighting : fresh) {
      const auto a = located(sighting, compressedEstimate()), b = located(sighting, fullEstimate());
      id_of_place_[sighting.place] =
          filters_.append(a.position, core::vehicleJacobian(a, kPlacement, kStates),
                          a.G_measurement * noise * a.G_measurement.transpose(), b.position,
                          core::vehicleJacobian(b, kPlacement, kStates),
                          b.G_measurement * noise * b.G_measurement.transpose());
    }
  }

  std::vector<FilterPair::Row> rows(const std::vector<Sighting>& sightings,
                                    const Eigen::Matrix2d& noise, const Estimate& at) const {
    std::vector<FilterPair::Row> result;
    for (const Sighting& sighting : sightings) {
      const int id = id_of_place_.at(sighting.place);
      const core::RangeBearing z =
          core::predictRangeBearing(at.pose(), kSensor, at.landmarks.at(id));
      const Eigen::Vector2d innovation(sighting.value[0] - z.value[0],
                                       core::wrapAngle(sighting.value[1] - z.value[1]));
      result.push_back(
          {innovation, core::vehicleJacobian(z, kPlacement, kStates), {{id, z.H_landmark}}, noise});
    }
    return result;
  }

  static core::LocatedLandmark located(const Sighting& sighting, const Estimate& at) {
    return core::locateLandmark(at.pose(), kSensor, sighting.value[0], sighting.value[1]);
  }

  void removeAny() {
    if (id_of_place_.size() < 5) return;
    const auto index =
        std::uniform_int_distribution<std::size_t>(0, id_of_place_.size() - 1)(generator_);
    const auto victim = std::next(id_of_place_.begin(), static_cast<std::ptrdiff_t>(index));
    filters_.remove(victim->second);
    id_of_place_.erase(victim);
  }

  // --- GPS ------------------------------------------------------------------------------------
  static Eigen::Vector2d turnedLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

  Eigen::Vector2d fix() { return inverse(kTrueDatum) * truth_.position() + normal2(0.5, 0.5); }

  /// T_map_enu enters: its place by the present pose and fix, its yaw by a guess of 0.1 rad.
  void alignWithGps() {
    const Eigen::Vector2d measured = fix();
    const double yaw = kTrueDatum.yaw_rad + core::sampleNormal(generator_, 0.1);
    const auto initialise = [&](auto& filter, const Eigen::VectorXd& vehicle) {
      const Eigen::Vector2d rotated = core::Pose2{0.0, 0.0, yaw}.rotation() * measured;
      Eigen::MatrixXd G = Eigen::MatrixXd::Zero(3, kStates);
      G.topLeftCorner<2, 2>().setIdentity();
      Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
      J.topRightCorner<2, 1>() = -turnedLeft(rotated);
      const Eigen::Matrix3d noise =
          J * Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal() * J.transpose();
      const Eigen::Vector2d place = vehicle.head<2>() - rotated;
      filter.initialiseVehicleStates(kDatum, Eigen::Vector3d(place.x(), place.y(), yaw), G, noise);
    };
    initialise(filters_.compressed(), filters_.compressed().vehicle());
    initialise(filters_.full(), filters_.full().state().head(kStates));
  }

  void fixPosition() {
    const Eigen::Vector2d measured = fix();
    filters_.update({gpsRow(measured, compressedEstimate())}, {gpsRow(measured, fullEstimate())});
  }

  static FilterPair::Row gpsRow(const Eigen::Vector2d& measured, const Estimate& at) {
    const core::Pose2 T_map_enu = core::Pose2::fromVector(at.vehicle.segment<3>(kDatum));
    const Eigen::Vector2d rotated = T_map_enu.rotation() * measured;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, kStates);
    H.leftCols<2>().setIdentity();
    H.block<2, 2>(0, kDatum) = -Eigen::Matrix2d::Identity();
    H.col(kDatum + 2) = -turnedLeft(rotated);
    return {T_map_enu.position() + rotated - at.pose().position(),
            H,
            {},
            0.25 * Eigen::Matrix2d::Identity()};
  }

  // --- Active area ------------------------------------------------------------------------------
  bool leaveCell() {
    const Eigen::Vector2d position = filters_.compressed().vehicle().head<2>();
    if ((position - area_centre_).cwiseAbs().maxCoeff() < 0.5 * kCell_m + 3.0) return false;
    if (!filters_.compressed().globalUpdate()) return false;
    area_centre_ = (position / kCell_m).array().round() * kCell_m;
    return true;
  }

  static inline const core::Pose2 kSensor{3.78, 0.5, 0.0};
  static inline const core::SensorPlacement kPlacement = [] {
    core::SensorPlacement placement;
    placement.T_base_sensor = kSensor;
    return placement;
  }();
  static inline const core::Pose2 kTrueDatum{-30.0, 12.0, 0.7};

  core::RandomGenerator generator_;
  core::MotionModel model_;
  FilterPair filters_;
  std::vector<Eigen::Vector2d> world_;
  std::map<std::size_t, int> id_of_place_;  // of landmarks in the state
  core::Pose2 truth_;
  Eigen::Vector2d area_centre_ = Eigen::Vector2d::Zero();
  int steps_ = 0;
};

}  // namespace hymm::test
