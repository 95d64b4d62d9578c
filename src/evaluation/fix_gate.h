#pragma once

#include <optional>

#include <Eigen/Core>

namespace hymm::core {

/// Leaves out GPS fixes that the vehicle cannot have reached: a fix is kept if its distance to the
/// last one kept is at most 15 m/s times the time between them. The first is always kept; so is
/// one that repeats the last. Fixes come in order of time.
class FixGate {
 public:
  static constexpr double kFastest_mps = 15.0;

  /// Whether the fix is kept.
  bool keep(double time_s, const Eigen::Vector2d& position_m);

 private:
  struct Kept {
    double time_s;
    Eigen::Vector2d position_m;
  };
  std::optional<Kept> last_;
};

}  // namespace hymm::core
