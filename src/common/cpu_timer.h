#pragma once

namespace hymm::core {

/// CPU time of the calling thread [s].
double threadCpuTime_s();

/// Adds the CPU time that the calling thread spends during its life to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum_s) : sum_s_(sum_s), start_s_(threadCpuTime_s()) {}
  ~CpuTimer() { sum_s_ += threadCpuTime_s() - start_s_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_s_;
  double start_s_;
};

}  // namespace hymm::core
