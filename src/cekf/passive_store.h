#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "cekf/interval_effect.h"
#include "cekf/tiled_symmetric_matrix.h"
#include "common/serial_worker.h"

namespace hymm::core {

/// State and covariance of everything as of the last global update. The update runs on a worker; as
/// soon as it is started, every read tells what will be when it is done, at a cost that depends on
/// the active part only, and waits for no more than the exchange of a pointer.
///
/// One thread calls; the worker is the store's own.
class PassiveStore {
 public:
  using TwoColumns = Eigen::Matrix<double, Eigen::Dynamic, 2>;

  /// With an inline worker the update is done when startUpdate() returns, and the same calls give
  /// the same bits.
  explicit PassiveStore(SerialWorker::Mode mode);
  /// Abandons an update under way, and jobs not yet begun.
  ~PassiveStore() { abandoned_ = true; }
  PassiveStore(const PassiveStore&) = delete;
  PassiveStore& operator=(const PassiveStore&) = delete;

  /// Starts a global update. None may be under way or held. A held one is in force as well, but
  /// nothing is carried out, and it can be discarded, until it is released.
  enum class Commitment { kAtOnce, kHeld };
  void startUpdate(IntervalEffect effect, Commitment commitment = Commitment::kAtOnce);
  /// What a held update does; null if none is held.
  std::shared_ptr<const IntervalEffect> heldEffect() const { return held_; }
  void releaseUpdate();
  void discardUpdate();
  /// Number of updates that can not be discarded, done or not.
  std::size_t updatesReleased() const { return updates_released_; }
  /// Whether a global update is under way. Throws what finish() throws.
  bool isUpdating();
  /// Releases the update if it is held, and waits for it and all jobs. Throws std::bad_alloc if
  /// there was too little memory.
  void finish();

  /// The pair of states at `index` and `index` + 1.
  Eigen::Vector2d state(int index) const;
  /// Covariance of the states `rows` with the pair at `index`.
  TwoColumns covariance(const std::vector<int>& rows, int index) const;

  /// All states, and their variances, as of the last update that is done.
  const Eigen::VectorXd& states() const { return *states_; }
  const Eigen::VectorXd& variances() const { return *variances_; }
  std::size_t updatesDone() const { return updates_done_; }

  /// Runs `job` on the worker, after the update under way and before a held or later one, with
  /// covariance and states at rest.
  using Job = std::function<void(const TiledSymmetricMatrix&, const Eigen::VectorXd&)>;
  void runJob(Job job);

  /// Both wait for the worker; a held update is saved, and stays held.
  void save(StateWriter& archive);
  void restore(StateReader& archive);

  /// CPU time of updates and jobs [s].
  double workerCpu_s() const { return worker_.cpu_s(); }

 private:
  using SharedVector = std::shared_ptr<const Eigen::VectorXd>;

  /// A global update on its way through the tiles. Written by the worker under the lock.
  struct Update {
    IntervalEffect effect;
    std::unordered_map<int, int> active_rows;  ///< by index
    /// Rows of W that a reader needed before the worker had gathered all.
    std::unordered_map<int, Eigen::RowVectorXd> rows;

    bool gathered = false;
    Eigen::MatrixXd W;  ///< origins x all states: their covariance before the update
    SharedVector states;
    int tile_rows_done = 0;
    int tiles_done_in_row = 0;
    SharedVector variances;
    bool done = false;

    int activeRow(int index) const;
    bool isTileNew(int a, int b) const;
  };

  // By the caller's thread, under the lock, while there is an update.
  TwoColumns covarianceDuringUpdate(const std::vector<int>& rows, int index) const;
  Eigen::RowVectorXd originRow(int index) const;

  void carryOutLater();

  // By the worker.
  void carryOut(Update& update);
  void growTo(int size);
  void gather(Update& update);
  void replaceTiles(Update& update);

  mutable std::mutex mutex_;  ///< over update_ and the places of the tiles
  TiledSymmetricMatrix tiles_;
  mutable std::optional<Update> update_;
  SharedVector states_, variances_;
  SharedVector worker_states_;  ///< as of the last update that the worker has done
  std::size_t updates_done_ = 0;
  std::size_t updates_released_ = 0;
  std::shared_ptr<const IntervalEffect> held_;  ///< of update_, if that is held
  std::atomic<bool> abandoned_{false};
  SerialWorker worker_;  ///< last: its jobs end before what they use
};

}  // namespace hymm::core
