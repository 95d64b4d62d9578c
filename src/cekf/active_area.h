#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "cekf/cekf_slam_config.h"
#include "cekf/compressed_ekf.h"

namespace hymm::core {

/// Decides when the filter updates globally: when the vehicle has left its cell, when the active
/// part has grown too large, or when a correction shall reach all landmarks. An update that is due
/// while the last one is pending waits for it, and the active part goes on growing; only when that
/// has grown to twice its bound does the caller wait.
class ActiveArea {
 public:
  struct Counts {
    std::size_t switches = 0;        ///< times that the vehicle left its cell
    std::size_t global_updates = 0;  ///< started
    std::size_t deferred = 0;        ///< of them, that had to wait for the one before
    std::size_t waits = 0;  ///< times that the caller waited, since the active part was full
  };

  explicit ActiveArea(const ActiveAreaConfig& config) : config_(config) {}

  /// Whether the vehicle has left its cell; the area is then around it.
  bool follow(const Eigen::Vector2d& position);

  /// The next update is due whatever the active part's size.
  void demandUpdate() { due_ = true; }

  /// Starts the global update if it is due and can be.
  void updateIfDue(CompressedEkf& filter);

  /// Around the origin again, as at the start. Counts go on.
  void reset();

  const Counts& counts() const { return counts_; }

  template <class Archive>
  void describeState(Archive& archive) {
    archive(centre_, due_, deferred_);
  }

 private:
  static int sizeOf(const CompressedEkf& filter);

  ActiveAreaConfig config_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  bool due_ = false;
  bool deferred_ = false;  ///< the update that is due has been counted as deferred
  Counts counts_;
};

}  // namespace hymm::core
