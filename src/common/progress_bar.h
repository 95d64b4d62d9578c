#pragma once

#include <cstddef>
#include <string>

namespace hymm::core {

/// A bar on standard error that shows how much of a job is done. Where standard error is not a
/// terminal it writes nothing, so that logs stay clean.
class ProgressBar {
 public:
  ProgressBar(std::string label, std::size_t total);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Cheap: redraws only when the percentage has changed.
  void update(std::size_t done);

 private:
  std::string label_;
  std::size_t total_;
  bool is_visible_;
  std::size_t percent_ = 0;
};

}  // namespace hymm::core
