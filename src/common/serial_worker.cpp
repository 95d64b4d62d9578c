#include "common/serial_worker.h"

#include <utility>

#include "common/cpu_timer.h"

namespace hymm::core {

SerialWorker::~SerialWorker() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SerialWorker::run(std::function<void()> job) {
  if (mode_ == Mode::kInline) {
    execute(job);
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  if (!thread_.joinable()) thread_ = std::thread(&SerialWorker::work, this);
  changed_.notify_all();
}

void SerialWorker::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty() && !busy_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

std::size_t SerialWorker::pending() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return jobs_.size() + (busy_ ? 1U : 0U);
}

double SerialWorker::cpu_s() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cpu_s_;
}

void SerialWorker::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    std::function<void()> job = std::move(jobs_.front());
    jobs_.pop_front();
    busy_ = true;
    lock.unlock();
    execute(job);
    job = nullptr;  // what it holds may be large, and is freed without the lock
    lock.lock();
    busy_ = false;
    changed_.notify_all();
  }
}

void SerialWorker::execute(const std::function<void()>& job) {
  double cpu_s = 0.0;
  std::exception_ptr failure;
  {
    const CpuTimer timer(cpu_s);
    try {
      job();
    } catch (...) {
      failure = std::current_exception();
    }
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  cpu_s_ += cpu_s;
  if (failure && !failure_) failure_ = failure;
}

}  // namespace hymm::core
