#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace hymm::core {

/// Runs jobs one after the other, in the order given, on a thread of its own or at once on the
/// caller's. What the jobs write is visible to whoever waited for them.
class SerialWorker {
 public:
  enum class Mode { kBackground, kInline };

  explicit SerialWorker(Mode mode) : mode_(mode) {}
  /// Finishes the jobs.
  ~SerialWorker();
  SerialWorker(const SerialWorker&) = delete;
  SerialWorker& operator=(const SerialWorker&) = delete;

  /// Takes a job. What a job throws, the next wait() throws.
  void run(std::function<void()> job);

  /// Waits until all jobs are done.
  void wait();

  /// Jobs taken and not yet done.
  std::size_t pending() const;

  /// CPU time that jobs took so far [s].
  double cpu_s() const;

 private:
  void work();
  void execute(const std::function<void()>& job);

  const Mode mode_;
  mutable std::mutex mutex_;  ///< over everything below
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  bool busy_ = false;
  bool stopping_ = false;
  std::exception_ptr failure_;
  double cpu_s_ = 0.0;
  std::thread thread_;  ///< started with the first job
};

}  // namespace hymm::core
