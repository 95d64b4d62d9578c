#pragma once

#include <deque>
#include <unordered_set>
#include <vector>

namespace hymm::core {

/// Landmarks that something hangs on, and that must therefore not be dropped. Who pins them learns
/// of the map later than the filter goes on, live by some time that nobody knows; so that a result
/// does not depend on it, a set that was told at one time is in force from a fixed delay later.
class LandmarkPins {
 public:
  explicit LandmarkPins(double delay_s) : delay_s_(delay_s) {}

  /// All ids to pin, as of a stamp; replaces what was told of earlier stamps, and of the same.
  void tell(double time_s, const std::vector<int>& ids);

  /// Those in force at a time. Times ascend.
  const std::unordered_set<int>& at(double time_s);

  /// What was told last is in force at once: another clock begins.
  void beginSession();

  void clear();

  template <class Archive>
  void describeState(Archive& archive) {
    archive(later_, now_);
  }

 private:
  struct Told {
    double from_s = 0.0;
    std::unordered_set<int> ids;

    template <class Archive>
    void describeState(Archive& archive) {
      archive(from_s, ids);
    }
  };

  double delay_s_;
  std::deque<Told> later_;  ///< by time
  std::unordered_set<int> now_;
};

}  // namespace hymm::core
