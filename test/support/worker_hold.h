#pragma once

#include <future>

#include "cekf/compressed_ekf.h"

namespace hymm::test {

/// Keeps the worker of a filter busy while it lives, so that a global update started meanwhile
/// stays pending. The filter's worker must be one in the background.
class WorkerHold {
 public:
  explicit WorkerHold(core::CompressedEkf& filter) {
    filter.readLater({}, [released = released_.get_future().share()](const core::EffectReader&) {
      released.wait();
    });
  }
  ~WorkerHold() { released_.set_value(); }
  WorkerHold(const WorkerHold&) = delete;
  WorkerHold& operator=(const WorkerHold&) = delete;

 private:
  std::promise<void> released_;
};

}  // namespace hymm::test
