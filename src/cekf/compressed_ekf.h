#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cekf/effect_reader.h"
#include "cekf/interval_effect.h"
#include "cekf/local_state.h"
#include "cekf/passive_store.h"
#include "cekf/vehicle_states.h"
#include "common/serial_worker.h"

namespace hymm::core {

/// A two-dimensional measurement that depends on the vehicle's states and a few pairs of others: a
/// landmark, and another landmark or what else tells on what is measured of it.
struct SparseMeasurement {
  static constexpr int kNone = -1;
  enum Pair { kLandmark, kDiameter, kError, kPairs };

  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();  ///< measured - predicted
  VehicleJacobian H_vehicle;                             ///< 2 x vehicle states, or 2 x 0 for none
  int landmarks[kPairs] = {kNone, kNone, kNone};         ///< slots
  Eigen::Matrix2d H_landmarks[kPairs] = {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero(),
                                         Eigen::Matrix2d::Zero()};
  Eigen::Matrix2d noise = Eigen::Matrix2d::Identity();

  /// Depends on all but the landmark as another linearisation of it does: they are linear.
  void dependAs(const SparseMeasurement& other) {
    for (int k = kDiameter; k < kPairs; ++k) {
      landmarks[k] = other.landmarks[k];
      H_landmarks[k] = other.H_landmarks[k];
    }
  }
};

/// How a new landmark depends on one that is there.
struct SlotJacobian {
  int slot = SparseMeasurement::kNone;
  Eigen::Matrix2d G = Eigen::Matrix2d::Zero();
};

/// How a point at `arm` from a body's centre moves with the body, by (x, y, yaw).
inline Eigen::Matrix<double, 2, 3> rigidMotion(const Eigen::Vector2d& arm) {
  Eigen::Matrix<double, 2, 3> A;
  A << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x();
  return A;
}

/// What a measurement did.
struct UpdateOutcome {
  double nis = 0.0;  ///< normalised innovation squared; NaN: refused, and nothing changed
  double largest_landmark_move_m = 0.0;  ///< of the active landmarks
  /// With innovations y of covariance S and their Jacobian H by the vehicle's states: H' S^-1 y,
  /// and H' S^-1 H.
  VehicleVector vehicle_score;
  VehicleMatrix vehicle_information;
};

/// Of an update that is refused.
inline UpdateOutcome refusedUpdate() {
  UpdateOutcome outcome;
  outcome.nis = std::numeric_limits<double>::quiet_NaN();
  return outcome;
}

/// The compressed extended Kalman filter: an EKF over the vehicle's states and any number of
/// two-dimensional landmarks, in which everything between two global updates costs time by the
/// number of ACTIVE landmarks only, yet the result equals the full EKF's.
///
/// A landmark is active from its first activate() or append() to the next globalUpdate(). Meanwhile
/// the effect of predictions and updates on all others is accumulated in phi, psi and theta:
///   P_ab = phi * W_b',  P_bc = P_bc0 - W_b * psi * W_c',  x_b = x_b0 + W_b * theta,
/// for active a and passive b, c, where W_b = cov(b, origin states) at the last global update. The
/// origin states are the vehicle's and those of each landmark activated since. Activating b appends
/// the row [-W_b * psi, I] to phi and a zero row and column to psi and theta, so that it is exact
/// at once, whatever the number of landmarks. (The paper's areas fix the origin states in advance;
/// this grows them by need.)
///
/// The global update itself runs on a worker. It is in force as soon as it is started: until it is
/// done, what it would write is computed for those that ask.
///
/// Landmarks are addressed by slots: small non-negative integers, reused after a global update.
class CompressedEkf {
 public:
  /// A filter with the given vehicle states and no landmark. Throws std::invalid_argument for sizes
  /// that do not fit.
  CompressedEkf(const Eigen::VectorXd& vehicle, const Eigen::MatrixXd& covariance,
                SerialWorker::Mode global_updates = SerialWorker::Mode::kInline);

  // --- State ---------------------------------------------------------------------------------
  int vehicleStates() const { return vehicle_states_; }
  VehicleVector vehicle() const { return x_.head(vehicle_states_); }
  VehicleMatrix vehicleCovariance() const;

  /// A landmark's position, active or not, as of now.
  Eigen::Vector2d landmark(int slot) const;
  /// Covariance between two landmarks, active or not, as of now.
  Eigen::Matrix2d covariance(int slot_a, int slot_b) const;
  /// Covariance between the vehicle's states (rows) and a landmark, active or not, as of now.
  Eigen::Matrix<double, Eigen::Dynamic, 2> vehicleLandmarkCovariance(int slot) const;
  /// Joint covariance of landmarks in the order given, as of now.
  Eigen::MatrixXd jointCovariance(const std::vector<int>& slots) const;

  /// Whether there is something in a slot.
  bool holds(int slot) const {
    return slot >= 0 && static_cast<std::size_t>(slot) < rows_.size() && rowOf(slot) != kFree;
  }
  bool isActive(int slot) const { return rowOf(slot) >= 0; }
  std::size_t landmarkCount() const { return landmark_count_; }
  std::size_t activeCount() const { return active_slots_.size(); }
  /// Slots of the active landmarks, without those of other quantities.
  std::vector<int> activeLandmarks() const;
  /// States that phi's columns stand for; grows until the next global update.
  int originStates() const { return origin_states_; }

  // --- Motion and measurements ---------------------------------------------------------------
  /// vehicle <- `vehicle`, with P_vv <- J * P_vv * J' + Q and P_v* <- J * P_v*. The products with
  /// everything but the vehicle are put off until something needs them.
  void predict(const VehicleVector& vehicle, const VehicleMatrix& J, const VehicleMatrix& Q);

  /// Joint update with measurements whose landmarks are all active. Refused when an innovation is
  /// not finite or the innovation covariance not positive definite.
  UpdateOutcome update(const std::vector<SparseMeasurement>& measurements);

  /// What such an update needs of all states, before anything changes.
  struct Linearised {
    Eigen::MatrixXd HP;        ///< H * P: measurements x states
    Eigen::MatrixXd L;         ///< Cholesky factor of S = H * P * H' + R, lower triangle
    Eigen::VectorXd whitened;  ///< L^-1 * innovations
  };
  /// Nothing if the update would be refused.
  std::optional<Linearised> linearise(const std::vector<SparseMeasurement>& measurements) const;
  /// The update with what linearise() has made of the same measurements and the same state.
  UpdateOutcome update(const std::vector<SparseMeasurement>& measurements, Linearised linearised);

  /// From now on, or no longer, updates change the vehicle's states alone. The landmarks' errors
  /// are considered all the same, so that the vehicle's covariance stays true (Schmidt's filter: of
  /// the optimal gain, the landmarks' rows are set to zero).
  void fixLandmarks(bool fixed) { landmarks_fixed_ = fixed; }
  bool areLandmarksFixed() const { return landmarks_fixed_; }

  /// The vehicle's and the active landmarks' states as the update would leave them, to linearise
  /// there.
  Eigen::VectorXd statesAfter(const Linearised& linearised) const;
  /// The same; nothing if the update would be refused.
  std::optional<Eigen::VectorXd> statesAfter(
      const std::vector<SparseMeasurement>& measurements) const;
  /// By how much the update would move landmarks, active or not [m]; empty if it would be refused.
  std::vector<Eigen::Vector2d> movesBy(const std::vector<SparseMeasurement>& measurements,
                                       const std::vector<int>& slots) const;
  /// Farthest that an active landmark is from its place among such states [m].
  double largestMove(const Eigen::VectorXd& states) const;
  /// The active landmark's place among such states.
  Eigen::Vector2d landmarkAmong(const Eigen::VectorXd& states, int slot) const {
    return states.segment<2>(rowOf(slot));
  }

  /// The vehicle's and the active landmarks' states, and their covariance.
  Eigen::VectorXd activeStates() const { return x_.head(states()); }
  Eigen::MatrixXd activeCovariance() const;
  /// Where the active landmark's place stands among them.
  int activeRow(int slot) const { return rowOf(slot); }

  /// Innovation covariance of measurements of active landmarks, without noise: 2x2 blocks in their
  /// order, lower triangle.
  Eigen::MatrixXd innovationCovariance(const std::vector<SparseMeasurement>& measurements) const;
  /// A block of it between two measurements.
  Eigen::Matrix2d innovationCovariance(const SparseMeasurement& a,
                                       const SparseMeasurement& b) const;

  // --- Landmarks -------------------------------------------------------------------------------
  /// Makes a passive landmark active; does nothing to an active one.
  void activate(int slot);

  /// New active landmark at `position` = g(vehicle, z): covariance G * P_vv * G' + noise; g may
  /// depend on active slots as well. Returns its slot.
  int append(const Eigen::Vector2d& position, const VehicleJacobian& G,
             const Eigen::Matrix2d& noise, const SlotJacobian& other = {},
             const SlotJacobian& another = {});

  /// New active pair of states that are no place but something else that measurements depend on,
  /// independent of all others. In all but landmarkCount() and the moves that are told of updates
  /// it is as a landmark. Returns its slot.
  int appendQuantities(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance);

  /// Takes a landmark out of the state (marginalises it). Throws std::invalid_argument if there is
  /// none in this slot.
  void remove(int slot);

  /// Redefines an active landmark's error: `gain` times the error of a vehicle state is added to it
  /// (P <- T * P * T' with T = I + gain * e'), while the estimates stay.
  void addVehicleError(int slot, const Eigen::Vector2d& gain, int vehicle_state);

  /// Redefines the errors of the vehicle's states and of what is active, e <- T * e; the estimates
  /// stay. `T` multiplies a matrix of such rows, activeStates()' order, from the left.
  void redefineErrors(const std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>& T);
  /// Moves the estimates alone, and no passive ones.
  void moveStates(const Eigen::VectorXd& by) { x_.head(states()) += by; }

  /// Adds an error that the vehicle's pose has, of covariance `noise` (x, y, yaw), and that active
  /// landmarks have with it, as one body.
  void addRigidNoise(const std::vector<int>& slots, const Eigen::Matrix3d& noise);

  /// An active pair of states goes on as a Gauss-Markov process of mean 0 and covariance
  /// `stationary`: `kept` of it is left, the rest is renewed (P_ss <- kept^2 * P_ss + (1 - kept^2)
  /// * stationary).
  void fade(int slot, double kept, const Eigen::Matrix2d& stationary);

  /// Replaces vehicle states [first, first + value.size()) by `value` = g(vehicle, z), of Jacobian
  /// G (wrt all vehicle states) and additional covariance `noise`.
  void initialiseVehicleStates(int first, const Eigen::VectorXd& value, const Eigen::MatrixXd& G,
                               const Eigen::MatrixXd& noise);

  // --- Global update -----------------------------------------------------------------------------
  /// Carries everything accumulated to all landmarks, after which none is active. False, and
  /// nothing happens, while the last one is still pending.
  bool globalUpdate();
  bool isGlobalUpdatePending() { return store_->isUpdating(); }
  /// Waits for the worker. A held update is released. Throws std::bad_alloc if there was too little
  /// memory.
  void finishGlobalUpdate() { store_->finish(); }

  // --- Going back --------------------------------------------------------------------------------
  /// All but what global updates have carried out, as of now.
  LocalState localState() const;
  /// Makes everything as it was then. False, and nothing happens, if a global update that was
  /// started since has been released. Global updates that are held can be undone, so:
  bool goBackTo(const LocalState& state);
  bool canGoBackTo(const LocalState& state) const;
  /// From now on global updates are held when they start: in force, and pending until released.
  void holdGlobalUpdates(bool hold) { hold_updates_ = hold; }
  /// Whether a global update is held, and was so already in `state`.
  bool isGlobalUpdateHeldSince(const LocalState& state) const {
    return store_->heldEffect() && state.held &&
           state.updates_released == store_->updatesReleased();
  }
  void releaseGlobalUpdate() { store_->releaseUpdate(); }

  /// Number of global updates done, and where the last one put a passive landmark, with the trace
  /// of its covariance. Unlike landmark(), without what was accumulated since.
  std::size_t globalUpdatesDone() const { return store_->updatesDone(); }
  Eigen::Vector2d settledPosition(int slot) const {
    return store_->states().segment<2>(storeIndex(slot));
  }
  double settledVariance(int slot) const {
    return store_->variances().segment<2>(storeIndex(slot)).sum();
  }

  /// Runs `job` on the worker with what is known now of the landmarks in `slots`, whatever happens
  /// meanwhile; the reader addresses them by storeIndex().
  void readLater(const std::vector<int>& slots, std::function<void(const EffectReader&)> job);

  /// CPU time of the worker [s].
  double workerCpu_s() const { return store_->workerCpu_s(); }

  static int storeIndex(int slot) { return kFirstLandmarkIndex + 2 * slot; }

  /// Keeps rounding and caller's angles in order: replaces a vehicle state by an equivalent value.
  void setVehicleState(int index, double value) { x_[index] = value; }

  // --- Saving
  // --------------------------------------------------------------------------------------
  /// Waits for the worker, and otherwise changes nothing. A global update that is held stays held
  /// here, and is released where it is restored.
  void save(StateWriter& archive);
  /// Into a filter of as many vehicle states. Throws InputError; the filter is then of no use.
  void restore(StateReader& archive);

 private:
  static constexpr int kFirstLandmarkIndex = kMaxVehicleStates;
  static constexpr int kPassive = -1;
  static constexpr int kFree = -2;

  void startInterval();
  int rowOf(int slot) const;
  int states() const { return vehicle_states_ + 2 * static_cast<int>(active_slots_.size()); }
  int storeIndexOfRow(int row) const;
  void reserveActive(int states, int origin_states);
  void flushMotion() const;
  int takeSlot(bool is_place);
  int appendRow(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance, bool is_place);
  void moveLastLandmarkTo(int row);

  double covarianceEntry(int row, int column) const {
    return row >= column ? P_(row, column) : P_(column, row);
  }
  void setCovarianceEntry(int row, int column, double value) {
    (row >= column ? P_(row, column) : P_(column, row)) = value;
  }

  /// Of two active landmarks, by their rows.
  Eigen::Matrix2d covarianceOfRows(int row_a, int row_b) const;

  /// Of measurements, one below the other: their Jacobians by the vehicle's states, H * P
  /// (x states) and H * phi (x origin states).
  Eigen::MatrixXd vehicleJacobian(const std::vector<SparseMeasurement>& measurements) const;
  Eigen::MatrixXd measurementsTimesCovariance(
      const std::vector<SparseMeasurement>& measurements) const;
  Eigen::MatrixXd measurementsTimesPhi(const std::vector<SparseMeasurement>& measurements) const;
  /// Lower triangle of HP * H'.
  Eigen::MatrixXd timesMeasurementsTransposed(
      const Eigen::MatrixXd& HP, const std::vector<SparseMeasurement>& measurements) const;

  /// W_b': covariance between the origin states and a passive landmark at the last global update.
  Eigen::Matrix<double, Eigen::Dynamic, 2> originCovariance(int slot) const;
  Eigen::Matrix<double, Eigen::Dynamic, 2> psiTimes(
      const Eigen::Matrix<double, Eigen::Dynamic, 2>& W) const;

  IntervalEffect effectSoFar() const;
  void updateVehicle(const Linearised& whitened, const Eigen::MatrixXd& Hphi);
  void tellVehicle(const std::vector<SparseMeasurement>& measurements, const Linearised& linearised,
                   UpdateOutcome& outcome) const;

  template <class Archive>
  void describeInterval(Archive& archive);
  void checkRestored(StateReader& archive);
  void checkOrigins(StateReader& archive, std::size_t stored) const;

  int vehicle_states_;

  // The active part. P_, phi_ and psi_ have spare capacity; of P_ and psi_ the lower triangle
  // counts. Rows: the vehicle's states, then active_slots_ in order.
  std::vector<int> active_slots_;
  Eigen::VectorXd x_;
  mutable Eigen::MatrixXd P_;
  mutable Eigen::MatrixXd phi_;
  Eigen::MatrixXd psi_;
  Eigen::VectorXd theta_;
  std::vector<int> origin_indices_;  ///< of the origin states in the store
  int origin_states_ = 0;

  // Motion not yet applied to the vehicle's cross-covariances and rows of phi.
  mutable Eigen::MatrixXd pending_J_;
  mutable bool motion_pending_ = false;

  bool hold_updates_ = false;
  std::unique_ptr<PassiveStore> store_;  ///< index: vehicle first, then landmarks

  std::vector<int> rows_;       ///< by slot: row in the active part, kPassive or kFree
  std::vector<bool> is_place_;  ///< by slot: holds a landmark's place
  std::vector<int> free_slots_;
  std::vector<int> retired_slots_;  ///< removed, but origin states until the global update
  std::size_t landmark_count_ = 0;
  bool landmarks_fixed_ = false;
};

}  // namespace hymm::core
